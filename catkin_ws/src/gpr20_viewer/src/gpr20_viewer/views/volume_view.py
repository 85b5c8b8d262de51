"""The whole image in 3D, or its three maximum projections where there is no OpenGL."""

from __future__ import annotations

from typing import Optional

import numpy as np
from PyQt5.QtGui import QOffscreenSurface, QOpenGLContext
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from gpr20_analysis.dataset import DEPTH, MM_PER_M, X, Y
from gpr20_common.message import Message
from gpr20_viewer.live_image import LiveImage
from gpr20_viewer.pictures import projection_picture
from gpr20_viewer.positions import Place
from gpr20_viewer.views.colours import LEVELS, QUIET, colour_numbers, level_colours
from gpr20_viewer.views.picture_plot import PicturePlot

MOST_POINTS = 60_000
"""Largest number of voxels that are drawn, the brightest ones."""
POINT_PX = 4
OLDEST_OPENGL = (2, 1)


def opengl_missing() -> Optional[Message]:
    """Return why there is no OpenGL here; None: there is."""
    try:
        import pyqtgraph.opengl  # noqa: F401
    except ImportError as error:
        return Message("3D needs PyOpenGL, which is not installed", details=error)
    context, surface = QOpenGLContext(), QOffscreenSurface()
    surface.create()
    if not (context.create() and context.makeCurrent(surface)):
        return Message("3D needs OpenGL, which this screen does not have")
    version = context.format().version()
    context.doneCurrent()
    if tuple(version) < OLDEST_OPENGL:
        return Message("3D needs a newer OpenGL than this screen has")
    return None


class ProjectionsView(QWidget):
    """The maxima of an image over depth, Y and X, in place of 3D.

    Attributes:
        plots: A plot for each axis that the maximum is taken over.
    """

    def __init__(self, reason: Message) -> None:
        super().__init__()
        self.plots = {
            DEPTH: PicturePlot(downwards=False, to_scale=False),
            Y: PicturePlot(downwards=True, to_scale=False),
            X: PicturePlot(downwards=True, to_scale=False),
        }
        text = f"Maximum projections instead of 3D: {reason}."
        label = QLabel(text)
        label.setStyleSheet(QUIET)
        label.setToolTip(text)
        # A long sentence may not widen the window.
        label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        row = QHBoxLayout()
        row.setSpacing(0)
        for plot in self.plots.values():
            plot.setMinimumSize(80, 100)
            row.addWidget(plot)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(label)
        layout.addLayout(row, 1)
        names = {DEPTH: (X, Y), Y: (X, DEPTH), X: (Y, DEPTH)}
        titles = {DEPTH: "depth", X: X, Y: Y}
        for over, (across, down) in names.items():
            # No title: there is room for a short word only, and the axes say what is meant.
            self.plots[over].set_texts("", f"{titles[across]} [mm]", f"{titles[down]} [mm]")

    def show_image(
        self, image: Optional[LiveImage], turn: int, range_db: float, db_per_ns: float
    ) -> None:
        """Draw an image; None: nothing."""
        for over, plot in self.plots.items():
            picture = None
            if image is not None:
                picture = projection_picture(image, turn, over, db_per_ns)
            plot.show_picture(picture, range_db)

    def show_cursor(self, place: Place) -> None:
        """Draw the cursor."""
        x_mm, y_mm, depth_mm = (one * MM_PER_M for one in (place.x_m, place.y_m, place.depth_m))
        self.plots[DEPTH].show_cursor(x_mm, y_mm)
        self.plots[Y].show_cursor(x_mm, depth_mm)
        self.plots[X].show_cursor(y_mm, depth_mm)


class PointsView(QWidget):
    """The brightest voxels of an image in 3D; drag to turn it, scroll to zoom."""

    def __init__(self) -> None:
        super().__init__()
        import pyqtgraph.opengl as gl

        self._view = gl.GLViewWidget()
        self._view.setBackgroundColor("k")
        self._points = gl.GLScatterPlotItem(pos=np.zeros((0, 3)), size=POINT_PX)
        self._points.setGLOptions("translucent")
        self._cursor = gl.GLLinePlotItem(
            pos=np.zeros((2, 3)), color=(1.0, 0.4, 0.1, 1.0), mode="lines", width=2
        )
        self._box = gl.GLBoxItem()
        for item in (self._box, self._points, self._cursor):
            self._view.addItem(item)
        label = QLabel("3D: voxels above the colour scale's lowest level")
        label.setStyleSheet(QUIET)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(label)
        layout.addWidget(self._view, 1)
        self._centre_mm: Optional[np.ndarray] = None
        self._size_mm = np.ones(3)

    def show_image(
        self, image: Optional[LiveImage], turn: int, range_db: float, db_per_ns: float
    ) -> None:
        """Draw an image; None: nothing."""
        if image is None:
            self._points.setData(pos=np.zeros((0, 3)))
            return
        levels_db = image.levels_db(turn, db_per_ns)
        lowest_db = -range_db
        if np.count_nonzero(levels_db > lowest_db) > MOST_POINTS:
            lowest_db = float(np.partition(levels_db.ravel(), -MOST_POINTS)[-MOST_POINTS])
        found = np.flatnonzero(levels_db > lowest_db)
        # The brightest first: a faint voxel in front of it lets it through only if drawn later.
        found = found[np.argsort(-levels_db.ravel()[found])]
        layer, row, column = np.unravel_index(found, levels_db.shape)
        axes_mm = [one * MM_PER_M for one in (image.x_m, image.y_m, -image.depth_m)]
        places_mm = np.column_stack((axes_mm[0][column], axes_mm[1][row], axes_mm[2][layer]))
        ends = np.array([[np.min(one), np.max(one)] for one in axes_mm])
        self._look_at(ends)
        shown_db = levels_db[layer, row, column]
        colours = np.ones((len(shown_db), 4))
        colours[:, :3] = level_colours()[colour_numbers(shown_db, range_db)] / float(LEVELS)
        colours[:, 3] = np.clip(1.0 + shown_db / range_db, 0.02, 1.0) ** 2
        self._points.setData(pos=places_mm, color=colours)

    def show_cursor(self, place: Place) -> None:
        """Draw the cursor."""
        if self._centre_mm is None:
            return
        at = MM_PER_M * np.array([place.x_m, place.y_m, -place.depth_m])
        ends = []
        for axis in range(3):
            for side in (-0.5, 0.5):
                end = at.copy()
                end[axis] = self._centre_mm[axis] + side * self._size_mm[axis]
                ends.append(end)
        self._cursor.setData(pos=np.array(ends))

    def _look_at(self, ends_mm: np.ndarray) -> None:
        import pyqtgraph

        centre_mm, size_mm = ends_mm.mean(axis=1), np.ptp(ends_mm, axis=1)
        if self._centre_mm is not None and np.array_equal(size_mm, self._size_mm):
            return
        self._centre_mm, self._size_mm = centre_mm, size_mm
        self._box.setSize(*size_mm)
        self._box.resetTransform()
        self._box.translate(*ends_mm[:, 0])
        distance_mm = 1.35 * float(np.linalg.norm(size_mm))
        self._view.opts["center"] = pyqtgraph.Vector(*centre_mm)
        self._view.setCameraPosition(distance=distance_mm, elevation=25, azimuth=-60)


def new_volume_view(flat: bool) -> QWidget:
    """Return the view of the whole image.

    Args:
        flat: Do not use OpenGL even if it is there.
    """
    reason = Message("switched off") if flat else opengl_missing()
    return PointsView() if reason is None else ProjectionsView(reason)
