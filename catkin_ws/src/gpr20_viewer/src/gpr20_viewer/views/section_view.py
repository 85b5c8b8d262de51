"""A vertical section of the image: depth over X or Y."""

from __future__ import annotations

from gpr20_viewer.views.colours import CANDIDATE
from gpr20_viewer.views.picture_plot import CANDIDATE_ANCHOR, Marks, PicturePlot


class SectionView(PicturePlot):
    """A section; the depth grows downwards.

    Attributes:
        candidates: Marks of candidates.
    """

    def __init__(self) -> None:
        super().__init__(downwards=True, to_scale=False)
        self.candidates = Marks(self, "d", CANDIDATE, CANDIDATE_ANCHOR)
