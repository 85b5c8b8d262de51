"""Say on the screen what the window waits for, then become the window's command.

waiting_screen.py COMMAND ...

The master runs on the PC. Until it answers there is no window, and a black screen says nothing.
"""

from __future__ import annotations

import os
import re
import socket
import sys
import threading
from pathlib import Path
from typing import Callable, List, Mapping, Optional

from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import QApplication, QLabel

from gpr20_common.catalogue import Language, language_from_code, read_catalogue
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.links import answers
from gpr20_common.message import Message
from gpr20_operator.files.settings_file import SettingsFile
from gpr20_user_interface.look.settings import settings_from

NAME = "/gpr20_waiting_screen"
ANSWER_LIMIT_S = 3.0
POLL_S = 1.0
SETTINGS = "~/.config/gpr20/window.yaml"
STYLE = "background: #101418; color: #e8eaed; font-size: 28px; padding: 40px"


def has_address(address: str) -> bool:
    """Return whether this computer has an IPv4 address."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((address, 0))
        except OSError:
            return False
    return True


def missing(
    environment: Mapping[str, str],
    has_own: Callable[[str], bool] = has_address,
    has_master: Callable[[str], bool] = lambda uri: answers(uri, NAME, ANSWER_LIMIT_S),
) -> Optional[Message]:
    """Return what the window waits for, and what to do; None if it can start."""
    own, server = environment.get("GPR20_ROBOT", ""), environment.get("GPR20_SERVER", "")
    if own and not _is_exported(environment) and not has_own(own):
        return Message(
            "Waiting for the link to the PC: this computer does not have the address {address}. "
            "Connect the cable, and switch the PC on.",
            address=own,
        )
    if has_master(environment["ROS_MASTER_URI"]):
        return None
    if server:
        return Message(
            "Waiting for the PC {address}. Switch it on, and check the cable.", address=server
        )
    return Message("The robot's programs are starting.")


def _is_exported(environment: Mapping[str, str]) -> bool:
    """Return whether somebody has chosen where ROS listens; gpr20's env-hooks set it otherwise."""
    if environment.get("ROS_HOSTNAME"):
        return True
    return environment.get("ROS_IP", "") != environment.get("GPR20_SET_ROS_IP", "")


def language_of(environment: Mapping[str, str], settings: Path) -> Language:
    """Return the language of the window: that of its arguments, else the remembered one."""
    asked = re.search(r"_language:=(\w+)", environment.get("GPR20_WINDOW_ARGUMENTS", ""))
    try:
        if asked and asked.group(1) != "auto":
            return language_from_code(asked.group(1))
        return settings_from(SettingsFile(settings).read()).language
    except Gpr20Error:
        # The window itself says what is wrong with them.
        return Language.ENGLISH


class WaitingScreen:
    """A sentence on the whole screen until nothing is missing."""

    def __init__(self, check: Callable[[], Optional[Message]], language: Language) -> None:
        self._check = check
        self._catalogue = read_catalogue(language)
        self._message: Optional[Message] = None
        self._ready = threading.Event()
        self.label = QLabel()
        self.label.setStyleSheet(STYLE)
        self.label.setWordWrap(True)
        self.label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._timer = QTimer()
        self._timer.timeout.connect(self._refresh)

    def show(self) -> None:
        """Show it, and check in a thread, because a master out of reach answers late."""
        threading.Thread(target=self._watch, daemon=True).start()
        self._timer.start(200)
        self.label.showFullScreen()

    def _watch(self) -> None:
        while True:
            self._message = self._check()
            if self._message is None:
                break
            threading.Event().wait(POLL_S)
        self._ready.set()

    def _refresh(self) -> None:
        if self._ready.is_set():
            QApplication.quit()
        elif self._message is not None:
            self.label.setText(self._catalogue.text(self._message))


def main(command: List[str]) -> None:
    """Wait for the link and the master, then become the command."""
    if missing(os.environ) is not None:
        application = QApplication(sys.argv[:1])
        language = language_of(os.environ, Path(SETTINGS).expanduser())
        screen = WaitingScreen(lambda: missing(os.environ), language)
        screen.show()
        application.exec_()
    os.execvp(command[0], command)


if __name__ == "__main__":
    main(sys.argv[1:])
