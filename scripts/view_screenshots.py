"""Pictures of gpr20 view over a survey; started by screenshots.sh."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from PyQt5 import sip
from PyQt5.QtCore import QEventLoop, Qt, QTimer
from PyQt5.QtWidgets import QApplication
from window_kit import virtual_screen

from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.read.load import load_survey
from gpr20_common.catalogue import Language
from gpr20_common.low import catalogue_file
from gpr20_common.low.catalogue_file import read_catalogue
from gpr20_viewer.identity import SurveyIdentity
from gpr20_viewer.picks_file import PicksFile
from gpr20_viewer.positions import Place
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views.application import utc_now
from gpr20_viewer.views.main_window import SIZE_PX, MainWindow
from gpr20_viewer.views.pick_desk import PickDesk

LOOK_MS = 50
LIMIT_MS = 300_000
MOST_PICKS = 3


def wait_for_image(window: MainWindow) -> None:
    """Let the window work until it shows an image with its candidates."""
    loop, timer, limit = QEventLoop(), QTimer(), QTimer()
    timer.timeout.connect(lambda: None if window.is_computing else loop.quit())
    limit.setSingleShot(True)
    limit.timeout.connect(lambda: loop.exit(1))
    timer.start(LOOK_MS)
    limit.start(LIMIT_MS)
    if loop.exec_():
        raise SystemExit("the image was not computed in time")


def take_picture(survey: Path, language: Language, path: Path) -> None:
    """Open the window, pick the first candidates and take a picture."""
    catalogue = read_catalogue(language)
    session = ViewSession(load_survey(survey), ImageOptions(), find_candidates)
    with tempfile.TemporaryDirectory() as folder:
        picks = Path(folder) / f"{survey.name}.picks.json"
        file = PicksFile(picks, SurveyIdentity.of(session.survey))
        desk = PickDesk(file, "", utc_now, catalogue)
        window = MainWindow(session, desk, survey.name, catalogue)
        window.show()
        window.candidates.searched.setChecked(True)
        wait_for_image(window)
        listed = [one for one in window.scene.candidates if not one.is_doubtful]
        for one in reversed(listed[:MOST_PICKS]):
            window.move_to(Place(one.x_m, one.y_m, one.depth_m))
            window.pick()
        # Where the picks of the viewer are for a survey of a robot, not in the folder of this run.
        stored = catalogue.tr("Picks are stored in {path}", path=f"../{picks.name}")
        desk.table.show_state(stored, wrong=False)
        wait_for_image(window)
        if not window.grab().save(str(path)):
            raise SystemExit(f"{path} cannot be written")
        print(path)
        window.close()


def main() -> None:
    """Take the pictures of the survey that is named into the folder that is named."""
    survey, folder = Path(sys.argv[1]), Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    width, height = SIZE_PX
    with virtual_screen(f"{width + 40}x{height + 80}x24"):
        # The second window draws with the programs that the first one compiled.
        QApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
        application = QApplication([])
        for language in catalogue_file.languages():
            take_picture(survey, language, folder / f"view_{language.value}.png")
        # Before its screen is gone.
        sip.delete(application)


if __name__ == "__main__":
    main()
