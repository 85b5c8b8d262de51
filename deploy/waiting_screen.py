"""Say on the screen that the master is waited for, then become the window's command.

waiting_screen.py COMMAND ...

The master runs on the PC. Until it answers there is no window, and a black screen says nothing.
"""

from __future__ import annotations

import os
import sys
from typing import List, Mapping

from PyQt5.QtCore import Qt, QTimer
from PyQt5.QtWidgets import QApplication, QLabel

from gpr20_common.catalogue import Language, read_catalogue
from gpr20_common.low.links import answers
from gpr20_common.message import Message

NAME = "/gpr20_waiting_screen"
ANSWER_LIMIT_S = 3.0
POLL_MS = 500
LANGUAGES = (Language.ENGLISH, Language.SPANISH)
STYLE = "background: #101418; color: #e8eaed; font-size: 28px; padding: 40px"


def sentence(environment: Mapping[str, str]) -> Message:
    """Return what the window waits for, and what to do."""
    server = environment.get("GPR20_SERVER", "")
    if server:
        return Message(
            "Waiting for the PC {address}. Switch it on, and check the cable.", address=server
        )
    return Message("The robot's programs are starting.")


def main(command: List[str]) -> None:
    """Show the sentence until the master answers, then become the command."""
    application = QApplication(sys.argv[:1])
    # In each language: which one the window has is not known yet.
    texts = [read_catalogue(one).text(sentence(os.environ)) for one in LANGUAGES]
    label = QLabel("\n\n".join(texts))
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
