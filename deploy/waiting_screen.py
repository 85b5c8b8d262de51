"""Say on the screen that the master is waited for, then become the window's command.

waiting_screen.py COMMAND ...

The master runs on the PC. Until it answers there is no window, and a black screen says nothing.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import List, Mapping

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
POLL_MS = 500
SETTINGS = "~/.config/gpr20/window.yaml"
STYLE = "background: #101418; color: #e8eaed; font-size: 28px; padding: 40px"


def sentence(environment: Mapping[str, str]) -> Message:
    """Return what the window waits for, and what to do."""
    server = environment.get("GPR20_SERVER", "")
    if server:
        return Message(
            "Waiting for the PC {address}. Switch it on, and check the cable.", address=server
        )
    return Message("The robot's programs are starting.")


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


def main(command: List[str]) -> None:
    """Show the sentence until the master answers, then become the command."""
    application = QApplication(sys.argv[:1])
    catalogue = read_catalogue(language_of(os.environ, Path(SETTINGS).expanduser()))
    label = QLabel(catalogue.text(sentence(os.environ)))
    label.setStyleSheet(STYLE)
    label.setWordWrap(True)
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.showFullScreen()

    def check() -> None:
        if answers(os.environ["ROS_MASTER_URI"], NAME, ANSWER_LIMIT_S):
            application.quit()

    timer = QTimer()
    timer.timeout.connect(check)
    timer.start(POLL_MS)
    application.exec_()
    os.execvp(command[0], command)


if __name__ == "__main__":
    main(sys.argv[1:])
