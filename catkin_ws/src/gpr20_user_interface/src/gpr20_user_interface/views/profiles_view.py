"""The list of profiles: load one, save the fields as one, delete one."""

from __future__ import annotations

from typing import List

from PyQt5.QtCore import QEvent, pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QListWidget, QPushButton, QVBoxLayout, QWidget

from gpr20_user_interface.views.overlay import Overlay


class ProfilesView(Overlay):
    """Tells what the operator wants of which profile."""

    # Carry the name.
    load_pressed = pyqtSignal(str)
    delete_pressed = pyqtSignal(str)
    save_pressed = pyqtSignal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._can_save = False
        self.title = QLabel()
        self.title.setObjectName("title")
        self.names = QListWidget()
        self.load = self._button(self._on_load)
        self.save = self._button(self.save_pressed.emit)
        self.delete = self._button(self._on_delete)
        self.close_button = self._button(self.hide)
        self.names.currentRowChanged.connect(lambda _row: self._show_buttons())
        row = QHBoxLayout()
        for button in (self.load, self.save, self.delete, self.close_button):
            row.addWidget(button, 1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(16, 10, 16, 10)
        layout.addWidget(self.title)
        layout.addWidget(self.names, 1)
        layout.addLayout(row)
        self._write()

    def show_names(self, names: List[str], can_save: bool) -> None:
        """Open with the names of all profiles.

        Args:
            names: All names.
            can_save: Whether the fields hold parameters that can be kept.
        """
        self._can_save = can_save
        self.names.clear()
        self.names.addItems(names)
        self._show_buttons()
        self.open()

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        if event.type() == QEvent.Type.LanguageChange:
            self._write()
        super().changeEvent(event)

    def _write(self) -> None:
        self.title.setText(self.tr("Profiles of parameters"))
        self.load.setText(self.tr("LOAD"))
        self.save.setText(self.tr("SAVE AS"))
        self.close_button.setText(self.tr("CLOSE"))
        self._show_buttons()

    def _show_buttons(self) -> None:
        chosen = self.names.currentItem() is not None
        self.load.setEnabled(chosen)
        self.delete.setEnabled(chosen)
        self.delete.setProperty("asked", False)
        self.delete.setText(self.tr("DELETE"))
        self.save.setEnabled(self._can_save)

    def _on_load(self) -> None:
        self.hide()
        self.load_pressed.emit(self.names.currentItem().text())

    def _on_delete(self) -> None:
        # One touch may be an accident.
        if self.delete.property("asked"):
            self.delete_pressed.emit(self.names.currentItem().text())
            return
        self.delete.setProperty("asked", True)
        self.delete.setText(self.tr("SURE?"))

    def _button(self, act: object) -> QPushButton:
        button = QPushButton()
        button.clicked.connect(lambda: act())  # type: ignore[operator]
        return button
