"""The list of the markers of a survey; one can be shown or removed."""

from __future__ import annotations

from typing import Optional, Tuple

from PyQt5.QtCore import Qt, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QListWidget, QVBoxLayout, QWidget

from gpr20_operator.ground.texts import place_text
from gpr20_operator.plan.hold_question import remove_marker_question
from gpr20_survey.plan.markers import Marker
from gpr20_user_interface.look.translation import shown_text
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import new_button


class MarkersSheet(Overlay):
    """Lists markers."""

    # A Marker.
    show_wanted = pyqtSignal(object)
    remove_wanted = pyqtSignal(object)

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.markers: Tuple[Marker, ...] = ()
        self.title, self.details, self.list = QLabel(), QLabel(), QListWidget()
        self.title.setObjectName("title")
        self.list.setWordWrap(True)
        self.list.currentRowChanged.connect(lambda _row: self._show_choice())
        self.details.setTextFormat(Qt.TextFormat.PlainText)
        self.details.setWordWrap(True)
        self.confirm = HoldSheet(window)
        self.show_button, self.remove = new_button(self._on_show), new_button(self._on_remove)
        self.close_button = new_button(self.hide)
        keys = QHBoxLayout()
        for button in (self.show_button, self.close_button):
            keys.addWidget(button, 1)
        # Far from where other sheets have OK and CLOSE: a bounced touch must not hold it.
        top = QHBoxLayout()
        top.addWidget(self.title, 1)
        top.addWidget(self.remove)
        column = QVBoxLayout(self)
        column.addLayout(top)
        column.addWidget(self.list, 1)
        column.addWidget(self.details)
        column.addLayout(keys)
        self.retranslate()

    @property
    def chosen(self) -> Optional[Marker]:
        """The marker that was touched; None: none."""
        row = self.list.currentRow()
        return self.markers[row] if 0 <= row < len(self.markers) else None

    def show_markers(self, markers: Tuple[Marker, ...]) -> None:
        """Open with a list."""
        self.set_markers(markers)
        self.open()

    def set_markers(self, markers: Tuple[Marker, ...]) -> None:
        """Show another list, if it has changed."""
        if markers != self.markers:
            self.markers = markers
            self._show()

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Markers"))
        self.show_button.setText(self.tr("Show"))
        self.remove.setText(self.tr("Remove"))
        self.close_button.setText(self.tr("Close"))
        self._show()

    def _show(self) -> None:
        row = self.list.currentRow()
        self.list.clear()
        for one in self.markers:
            place = shown_text(place_text(one.x_mm, one.y_mm, one.depth_mm))
            self.list.addItem(f"{place}: {one.text}" if one.text else place)
        self.list.setCurrentRow(min(row, len(self.markers) - 1))
        self._show_choice()

    def _show_choice(self) -> None:
        one = self.chosen
        for key in (self.show_button, self.remove):
            key.setEnabled(one is not None)
        made = "" if one is None else f"{one.time[:16].replace('T', ' ')} UTC {one.author}"
        self.details.setText(made or self.tr("Touch a marker."))

    def _on_show(self) -> None:
        if self.chosen is not None:
            self.hide()
            self.show_wanted.emit(self.chosen)

    def _on_remove(self) -> None:
        marker = self.chosen
        if marker is not None:
            place = place_text(marker.x_mm, marker.y_mm, marker.depth_mm)
            question = remove_marker_question(place, marker.text)
            self.confirm.ask(question, lambda: self.remove_wanted.emit(marker))
