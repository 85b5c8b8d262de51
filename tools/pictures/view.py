"""The window of gpr20 view over the sample survey."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Tuple

from PyQt5 import sip
from PyQt5.QtWidgets import QApplication
from window_kit import virtual_screen

from gpr20_analysis import sample_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.read.load import load_survey
from gpr20_common.message import Message
from gpr20_survey.results.candidates import Candidate
from gpr20_viewer.picks_file import PicksFile, SurveyIdentity
from gpr20_viewer.positions import Place
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views.main_window import SIZE_PX, MainWindow
from gpr20_viewer.views.tables import PicksTab
from pictures.kit import save, wait

MOST_PICKS = 3


def found_in(window: MainWindow) -> Tuple[Candidate, ...]:
    """Return the candidates in the image that is shown."""
    return () if window.image is None else window.image.candidates.candidates


def take_picture(path: Path) -> None:
    """Open the window, pick the first candidates and take a picture."""
    survey = sample_survey()
    session = ViewSession(load_survey(survey), ImageOptions())
    with tempfile.TemporaryDirectory() as folder:
        picks = Path(folder) / f"{survey.name}.picks.json"
        file = PicksFile(picks, SurveyIdentity.of(session.survey))
        picked = PicksTab(file, "", lambda: "")
        window = MainWindow(session, picked, survey.name)
        window.show()
        wait(lambda: bool(found_in(window)), "the image has its candidates")
        for one in reversed(found_in(window)[:MOST_PICKS]):
            window.move_to(Place(one.x_m, one.y_m, one.depth_m))
            window.pick()
        # Where the picks of the viewer are for a survey of a robot, not in the folder of this run.
        stored = Message("Picks are stored in ../{path}", path=picks.name)
        picked.say(stored, wrong=False)
        save(window, path)
        window.close()


def make(folder: Path) -> None:
    """Take the picture."""
    width, height = SIZE_PX
    with virtual_screen(f"{width + 40}x{height + 80}x24"):
        application = QApplication([])
        take_picture(folder / "view_en.png")
        # Before its screen is gone.
        sip.delete(application)
