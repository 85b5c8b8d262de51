"""A vertical section of the image: depth over X or Y."""

from __future__ import annotations

from gpr20_analysis.viewer.views.picture_plot import PicturePlot


class SectionView(PicturePlot):
    """A section; the depth grows downwards."""

    def __init__(self) -> None:
        super().__init__(downwards=True, to_scale=False)
