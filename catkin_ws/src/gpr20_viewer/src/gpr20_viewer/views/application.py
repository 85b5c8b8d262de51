"""Opens the window."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pyqtgraph
from PyQt5 import sip
from PyQt5.QtCore import QTimer
from PyQt5.QtWidgets import QApplication

from gpr20_common.low.clock import time_of_day_us
from gpr20_survey.trace.utc_time import iso_text
from gpr20_viewer.picks_file import PicksFile, SurveyIdentity
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views.main_window import MainWindow
from gpr20_viewer.views.tables import PicksTab

# Python handles Ctrl-C only between its own instructions.
SIGNALS_PERIOD_MS = 200


def show(session: ViewSession, picks: Path, author: str, name: str) -> None:
    """Show the window; return when it was closed.

    Raises:
        PicksFileError: The stored picks are damaged or of another survey.
        KeyboardInterrupt: It was ended with Ctrl-C.
    """
    file = PicksFile(picks, SurveyIdentity.of(session.survey))
    application = QApplication.instance() or QApplication(sys.argv[:1])
    pyqtgraph.setConfigOptions(antialias=True)
    window = MainWindow(session, PicksTab(file, author, lambda: iso_text(time_of_day_us())), name)
    interrupted = []

    def interrupt(*_: object) -> None:
        interrupted.append(True)
        application.quit()

    former = {one: signal.signal(one, interrupt) for one in (signal.SIGINT, signal.SIGTERM)}
    ticks = QTimer()
    ticks.timeout.connect(lambda: None)
    ticks.start(SIGNALS_PERIOD_MS)
    try:
        window.show()
        application.exec_()
    finally:
        window.bridge.close()
        # Ctrl-C leaves it open.
        window.hide()
        sip.delete(window)
        for number, handler in former.items():
            signal.signal(number, handler)
    if interrupted:
        raise KeyboardInterrupt
