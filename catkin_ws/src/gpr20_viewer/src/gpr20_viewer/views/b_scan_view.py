"""The traces of a line over the delay, with the hyperbola of the place of the cursor."""

from __future__ import annotations

import numpy as np
import pyqtgraph
from PyQt5.QtCore import Qt

from gpr20_analysis.dataset import MM_PER_M
from gpr20_viewer.live_image import NS_PER_S
from gpr20_viewer.positions import Line, Place
from gpr20_viewer.views.colours import HYPERBOLA, SURFACE
from gpr20_viewer.views.picture_plot import PicturePlot


class BScanView(PicturePlot):
    """A B-scan; the delay grows downwards.

    Attributes:
        hyperbola: The curve of delays that an echo of the cursor's place has.
        surface: The curve of delays of the surface, by the recorded heights.
    """

    def __init__(self) -> None:
        super().__init__(downwards=True, to_scale=False)
        pen = pyqtgraph.mkPen(HYPERBOLA, width=2, style=Qt.PenStyle.DashLine)
        self.hyperbola = pyqtgraph.PlotCurveItem(pen=pen)
        self.surface = pyqtgraph.PlotCurveItem(pen=pyqtgraph.mkPen(SURFACE, width=1))
        for curve in (self.surface, self.hyperbola):
            self.addItem(curve, ignoreBounds=True)

    def show_hyperbola(
        self, line: Line, place: Place, permittivity: float, separation_m: float
    ) -> None:
        """Draw the delays of an echo from a place, and those of the surface."""
        across_mm = line.position_m * MM_PER_M
        delays_s = line.delays_s(place, permittivity, separation_m)
        self.hyperbola.setData(across_mm, delays_s * NS_PER_S)
        surface_s = line.surface_delays_s(separation_m)
        self.surface.setData(across_mm, surface_s * NS_PER_S)
        at_m = place.x_m if line.along == "x" else place.y_m
        at_ns = float(np.interp(at_m, line.position_m, delays_s)) * NS_PER_S
        self.show_cursor(at_m * MM_PER_M, at_ns)
