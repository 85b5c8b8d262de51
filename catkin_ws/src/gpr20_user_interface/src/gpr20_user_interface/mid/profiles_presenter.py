"""Between the list of profiles on the window and the profiles themselves."""

from __future__ import annotations

from typing import Callable

from PyQt5.QtCore import QObject

from gpr20_user_interface.errors import ProfileError
from gpr20_user_interface.mid.profiles import Profiles, is_name
from gpr20_user_interface.views.main_window import MainWindow


class ProfilesPresenter(QObject):
    """Carries the wishes out; tells the operator what went wrong."""

    def __init__(self, window: MainWindow, profiles: Profiles) -> None:
        super().__init__()
        self._window = window
        self._profiles = profiles
        window.control.profiles_pressed.connect(lambda: self._try(self._list))
        window.profiles.load_pressed.connect(lambda name: self._try(lambda: self._load(name)))
        window.profiles.delete_pressed.connect(lambda name: self._try(lambda: self._delete(name)))
        window.profiles.save_pressed.connect(lambda: self._try(self._ask_name))

    def _list(self) -> None:
        can_save = self._window.control.parameters is not None
        self._window.profiles.show_names(self._profiles.names(), can_save)

    def _load(self, name: str) -> None:
        self._window.control.show_parameters(self._profiles.load(name))

    def _delete(self, name: str) -> None:
        self._profiles.remove(name)
        self._list()

    def _ask_name(self) -> None:
        taken = self._profiles.names()

        def is_allowed(name: str) -> bool:
            return is_name(name) and name not in taken

        self._window.ask_profile_name(lambda name: self._try(lambda: self._save(name)), is_allowed)

    def _save(self, name: str) -> None:
        parameters = self._window.control.parameters
        if parameters is not None:
            self._profiles.save(name, parameters)
        self._list()

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except ProfileError as error:
            self._window.show_profile_trouble(str(error))
