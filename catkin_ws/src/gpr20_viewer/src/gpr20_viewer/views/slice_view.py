"""A horizontal slice of the image, as a map."""

from __future__ import annotations

import numpy as np

from gpr20_analysis.dataset import MM_PER_M
from gpr20_viewer.scene import Mark
from gpr20_viewer.views.colours import CANDIDATE, NO_DATA
from gpr20_viewer.views.picture_plot import CANDIDATE_ANCHOR, Marks, PicturePlot


class SliceView(PicturePlot):
    """A C-scan, true to scale.

    Attributes:
        candidates: Marks of candidates.
        without_data: Marks of positions without data.
    """

    def __init__(self) -> None:
        super().__init__(downwards=False, to_scale=True)
        self.candidates = Marks(self, "d", CANDIDATE, CANDIDATE_ANCHOR)
        self.without_data = Marks(self, "x", NO_DATA)

    def show_without_data(self, places_m: np.ndarray) -> None:
        """Mark the positions (x, y) without data."""
        self.without_data.show([Mark(x * MM_PER_M, y * MM_PER_M) for x, y in places_m])
