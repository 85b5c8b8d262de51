"""Scrolling by a finger: a list or a text is pulled, and a pull never chooses anything."""

from __future__ import annotations

from PyQt5.QtCore import QModelIndex, QPoint, Qt, pyqtSignal
from PyQt5.QtGui import QMouseEvent
from PyQt5.QtWidgets import (
    QAbstractItemView,
    QAbstractScrollArea,
    QListView,
    QScroller,
    QScrollerProperties,
    QWidget,
)

# A finger that moves farther than this pulls; a gloved one shakes by less [px].
TAP_PX = 12
# On the glass, before the list follows it [m].
PULL_M = 0.0025


def scroll_by_finger(area: QAbstractScrollArea) -> None:
    """Let a finger, or the left button of a mouse, pull what an area shows up and down."""
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    if isinstance(area, QAbstractItemView):
        area.setVerticalScrollMode(QAbstractItemView.ScrollMode.ScrollPerPixel)
    viewport = area.viewport()
    QScroller.grabGesture(viewport, QScroller.ScrollerGestureType.LeftMouseButtonGesture)
    scroller = QScroller.scroller(viewport)
    properties = scroller.scrollerProperties()
    metric = QScrollerProperties.ScrollMetric
    never = QScrollerProperties.OvershootPolicy.OvershootAlwaysOff
    properties.setScrollMetric(metric.DragStartDistance, PULL_M)
    # A tap of what still moves, however slowly, only stops it.
    properties.setScrollMetric(metric.MaximumClickThroughVelocity, 0.0)
    properties.setScrollMetric(metric.VerticalOvershootPolicy, never)
    properties.setScrollMetric(metric.HorizontalOvershootPolicy, never)
    scroller.setScrollerProperties(properties)


def scroll_everything(window: QWidget) -> None:
    """Let a finger pull every list and text of a window."""
    for area in window.findChildren(QAbstractScrollArea):
        if isinstance(area, QAbstractScrollArea):
            scroll_by_finger(area)


class FingerList(QListView):
    """A list that is pulled by a finger; only a tap reports a row."""

    tapped = pyqtSignal(QModelIndex)

    def __init__(self) -> None:
        super().__init__()
        self._pressed_at = QPoint()
        self._pulled = True
        # Qt would choose a row when it is pressed.
        self.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setUniformItemSizes(True)

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger comes."""
        self._pressed_at, self._pulled = event.pos(), False

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: the finger moves."""
        moved = event.pos() - self._pressed_at
        self._pulled = self._pulled or moved.manhattanLength() > TAP_PX

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: the finger leaves, or the list has begun to follow it."""
        self.mouseMoveEvent(event)
        row = self.indexAt(event.pos())
        if not self._pulled and row.isValid():
            self.tapped.emit(row)
        self._pulled = True

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        """Qt: a finger that comes soon after another touch."""
        self.mousePressEvent(event)
