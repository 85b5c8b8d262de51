"""Plans that are stored under a name: load one, save the fields as one, delete one."""

from __future__ import annotations

from typing import Callable, Optional

from PyQt5.QtCore import pyqtSignal
from PyQt5.QtWidgets import QHBoxLayout, QLabel, QListWidget, QVBoxLayout, QWidget

from gpr20_operator.errors import SettingsError
from gpr20_operator.plan.fields import Keys
from gpr20_operator.plan.hold_question import delete_profile_question
from gpr20_operator.plan.stored import MAX_NAME_LENGTH, Profiles, is_name
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_user_interface.widgets.hold_sheet import HoldSheet
from gpr20_user_interface.widgets.keys import Pad
from gpr20_user_interface.widgets.overlay import Overlay
from gpr20_user_interface.widgets.widgets import fill, new_button


class ProfilesSheet(Overlay):
    """Loads, saves and deletes profiles, which the window calls saved plans."""

    # Carries the SurveyParameters of a profile.
    loaded = pyqtSignal(object)
    # Carries the reason, a Message, why a profile cannot be used.
    failed = pyqtSignal(object)

    def __init__(self, window: QWidget, profiles: Profiles) -> None:
        super().__init__(window)
        self._profiles = profiles
        self._parameters: Optional[SurveyParameters] = None
        self.pad = Pad(window)
        self.confirm = HoldSheet(window)
        self.title = QLabel()
        self.title.setObjectName("title")
        self.names = QListWidget()
        self.load = new_button(lambda: self._try(self._load))
        self.save = new_button(lambda: self._try(self._ask_name))
        self.delete = new_button(self._ask_delete)
        self.close_button = new_button(self.hide)
        self.names.currentRowChanged.connect(lambda _row: self._show_buttons())
        row = QHBoxLayout()
        fill(row, (self.load, 1), (self.save, 1), (self.delete, 1), (self.close_button, 1))
        # Below the top bar: other sheets have their buttons to hold farther down.
        layout = QVBoxLayout(self)
        layout.setContentsMargins(16, 10, 16, 10)
        fill(layout, row, self.title, (self.names, 1))
        self.retranslate()

    def show_profiles(self, parameters: Optional[SurveyParameters]) -> None:
        """Open with all names; parameters None: the fields are wrong and cannot be saved."""
        self._parameters = parameters
        self._try(self._list)

    def retranslate(self) -> None:
        """Write the texts in the language of the application."""
        self.title.setText(self.tr("Saved plans"))
        self.load.setText(self.tr("LOAD"))
        self.save.setText(self.tr("SAVE AS"))
        self.close_button.setText(self.tr("CLOSE"))
        self._show_buttons()

    def _show_buttons(self) -> None:
        chosen = self.names.currentItem() is not None
        self.load.setEnabled(chosen)
        self.delete.setEnabled(chosen)
        self.delete.setText(self.tr("DELETE"))
        self.save.setEnabled(self._parameters is not None)

    def _list(self) -> None:
        names = self._profiles.names()
        self.names.clear()
        self.names.addItems(names)
        self._show_buttons()
        self.open()

    def _load(self) -> None:
        self.hide()
        self.loaded.emit(self._profiles.load(self.names.currentItem().text()))

    def _ask_delete(self) -> None:
        name = self.names.currentItem().text()
        self.confirm.ask(
            delete_profile_question(name), lambda: self._try(lambda: self._remove(name))
        )

    def _remove(self, name: str) -> None:
        self._profiles.remove(name)
        self._list()

    def _ask_name(self) -> None:
        taken = self._profiles.names()
        hint = self.tr("at most {most} characters").format(most=MAX_NAME_LENGTH)
        allowed = self.tr("1 to {most} of a to z, 0 to 9, - and _, inside also spaces")
        other = self.tr("this name is taken; write another one")

        def judge(name: str) -> str:
            if name in taken:
                return other
            return "" if is_name(name) else allowed.format(most=MAX_NAME_LENGTH)

        def deliver(name: str) -> None:
            self._try(lambda: self._save(name))

        self.pad.ask(deliver, self.tr("Save plan as"), hint, "", judge, Keys.LETTERS)

    def _save(self, name: str) -> None:
        if self._parameters is not None:
            self._profiles.save(name, self._parameters)
        self._list()

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except SettingsError as error:
            self.failed.emit(error.message)
