"""Pictures of the candidates of a stored survey in the window; started by screenshots.sh."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Callable

from PyQt5.QtWidgets import QApplication, QVBoxLayout, QWidget
from window_kit import run_until, virtual_screen

from gpr20_common.catalogue import Language
from gpr20_common.low import catalogue_file
from gpr20_common.low.clock import Clock
from gpr20_imaging.low.analysis_command import AnalysisCommand
from gpr20_imaging.low.usb_volumes import UsbVolumes
from gpr20_imaging.mid.imaging import Imaging
from gpr20_main_control.mid.survey_status import NO_PARAMETERS
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.results.survey_summary import SurveySummary
from gpr20_user_interface.mid.candidate_search import CandidateSearch, SearchState
from gpr20_user_interface.mid.events import ControlState
from gpr20_user_interface.mid.imaging_events import CandidatesFound
from gpr20_user_interface.mid.survey_model import Snapshot, SurveyModel
from gpr20_user_interface.views.candidates_sheet import CandidatesSheet
from gpr20_user_interface.views.look import DESIGN_HEIGHT_PX, DESIGN_WIDTH_PX, Look
from gpr20_user_interface.views.style_sheet import style_sheet
from gpr20_user_interface.views.top_bar import TopBar
from gpr20_user_interface.views.translation import Languages

LIMIT_S = 300.0
PERMITTIVITY = "5"


class LocalImaging:
    """The imaging of this computer, without its node.

    Args:
        imaging: It.
        listener: Called with each answer, in the thread that asks.
    """

    def __init__(self, imaging: Imaging, listener: Callable[[object], None]) -> None:
        self._imaging = imaging
        self._listener = listener

    def find_candidates(
        self, request_id: str, survey: str, permittivity: float, language: str
    ) -> None:
        """Find the candidates of a survey; wait until they are found."""
        found = self._imaging.find_candidates(request_id, survey, permittivity, language)
        self._listener(CandidatesFound(request_id, found.found, found.remarks))

    def cancel(self, request_id: str) -> None:
        """End a request."""
        self._imaging.cancel(request_id)


def idle_robot() -> Snapshot:
    """Return what the window knows of a simulated robot that waits for a survey."""
    model = SurveyModel(Clock())
    model.handle(ControlState(SurveyState.IDLE, NO_PARAMETERS, "", simulated=True))
    return model.snapshot()


def take_pictures(folder: Path, survey: Path, application: QApplication) -> None:
    """Search for candidates and take a picture in each language."""
    languages = Languages(application, Language.ENGLISH)
    described = json.loads((survey / "survey.json").read_text(encoding="utf-8"))
    chosen = SurveySummary(
        survey.name, described["survey_id"], described["started"], "", 0, 0, None, True,
        described["simulated"], None,
    )  # fmt: skip
    window = QWidget()
    window.setStyleSheet(style_sheet(Look()))
    window.resize(DESIGN_WIDTH_PX, DESIGN_HEIGHT_PX)
    column = QVBoxLayout(window)
    column.setContentsMargins(0, 0, 0, 0)
    bar = TopBar()
    bar.refresh(idle_robot())
    column.addWidget(bar)
    column.addStretch(1)
    ended: list = []
    imaging = Imaging(survey.parent, AnalysisCommand(), UsbVolumes(), lambda *_: None)
    search = CandidateSearch(LocalImaging(imaging, ended.append), time.monotonic)
    sheet = CandidatesSheet(window, search, lambda: languages.language.value)
    sheet.permittivity.setText(PERMITTIVITY)
    window.show()
    sheet.show_survey(chosen)
    for language in catalogue_file.languages():
        languages.use(language)
        sheet.find_button.click()
        run_until(lambda: bool(ended), "the search ends", LIMIT_S)
        search.on_event(ended.pop())
        sheet.refresh()
        if search.state is not SearchState.DONE:
            raise SystemExit(sheet.details.text())
        run_until(lambda: sheet.table.rowCount() > 0, "the list is shown", LIMIT_S)
        path = folder / f"candidates_{language.value}.png"
        if not window.grab().save(str(path)):
            raise SystemExit(f"{path} cannot be written")
        print(path)
    languages.close()
    imaging.close()


def main() -> None:
    """Take the pictures of the survey that is named into the folder that is named."""
    survey, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    with virtual_screen():
        take_pictures(folder, survey, QApplication([]))


if __name__ == "__main__":
    main()
