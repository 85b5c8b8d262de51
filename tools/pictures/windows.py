"""Pictures of the window of the robot, in each language, and of gpr20 view."""

from __future__ import annotations

import contextlib
import functools
import os
import tempfile
from pathlib import Path
from typing import Callable, Iterator, NamedTuple

import rosgraph
import rospy
from PyQt5 import sip
from PyQt5.QtWidgets import QApplication, QWidget
from robot_kit import free_port, running, simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_analysis import ImageOptions, load_survey, sample_survey
from gpr20_common import catalogue
from gpr20_common.catalogue import Language
from gpr20_msgs.msg import ControlStatus
from gpr20_operator.ground.sources import Layer
from gpr20_operator.jobs.job import Job, JobState
from gpr20_survey.results.hiding_map import Targets
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.window.main_window import MainWindow
from gpr20_user_interface.window.rail import TabName
from gpr20_viewer.picks_file import PicksFile, SurveyIdentity
from gpr20_viewer.positions import Place
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views import main_window as viewer
from gpr20_viewer.views.tables import PicksTab

SCENE = "catkin_ws/src/gpr20_simulator/scenes/imaging_targets.yaml"
PERMITTIVITY = 5.0  # of the scene
LIMIT_S, DRAWN_S = 300.0, 1.0
# Above the metallic sphere, between the depths of the two targets.
TARGET_MM = (155.0, 140.0, 60.0)
# What is measured of the survey that the pictures of the tabs show.
MEASURED = round(0.7 * 21 * 21 * 2)
REPLAYED = 20
# Lets the window live until a condition holds.
wait = functools.partial(run_until, limit_s=LIMIT_S)


def save(widget: QWidget, path: Path) -> None:
    """Write what a window shows after it was given time to draw."""
    run_events(DRAWN_S)
    if not widget.grab().save(str(path)):
        raise SystemExit(f"{path} cannot be written")
    print(path, flush=True)


class Shown(NamedTuple):
    """The window of the robot while it is shown."""

    window: MainWindow
    languages: Languages

    def take(self, path: Path, prepare: Callable[[], None] = lambda: None) -> None:
        """Prepare the window and take a picture, in each language."""
        for language in catalogue.languages():
            self.languages.use(language)
            prepare()
            save(self.window, path.with_name(f"{path.name}_{language.value}.png"))


@contextlib.contextmanager
def shown_window(data: Path, replay: bool = False) -> Iterator[Shown]:
    """Show the window of the robot whose master is known, on a screen of its own.

    Args:
        data: Folder of its profiles and settings.
        replay: Whether it shows a replay.
    """
    with virtual_screen():
        languages = Languages(QApplication([]), Language.ENGLISH)
        wait(rosgraph.is_master_online, "the master is there")
        rospy.init_node("pictures", disable_signals=True)
        interface = new_window(languages, data, replay)
        interface.begin()
        try:
            yield Shown(interface.window, languages)
        finally:
            interface.end()
            languages.close()
            rospy.signal_shutdown("the pictures are taken")


def window(folder: Path) -> None:
    """Take pictures of the plan, and of each tab during a survey."""
    with simulated_robot("time_scale:=50") as robot, shown_window(robot.data) as shown:
        window, operator = shown.window, Operator()
        wait(lambda: window.survey.snapshot.can_start, "the robot is ready")
        wait(lambda: window.survey.snapshot.health.trouble is None, "each part reports")
        shown.take(folder / "plan")
        # For the list of surveys.
        operator.start(x_points=3, y_points=3)
        wait(lambda: operator.code == ControlStatus.FINISHED, "a small survey ends")
        operator.start()
        wait(lambda: window.traces.live.radar.count >= MEASURED, "the survey shows both targets")
        window.ground.show_place(*TARGET_MM)

        def choose_survey() -> None:
            stored = window.traces.past
            wait(lambda: len(stored.surveys) == 2, "the list is there")
            window.past.choose(stored.surveys[1])

        for tab in TabName:
            window.show_tab(tab)
            prepare = choose_survey if tab is TabName.SURVEYS else lambda: None
            shown.take(folder / tab.value, prepare)
        window.show_tab(TabName.GROUND)
        wait(lambda: window.ground.model.image is not None, "an image is focused")
        window.ground.model.change(layer=Layer.FOCUSED)
        shown.take(folder / "focused")
        operator.stop()
        wait(lambda: operator.code == ControlStatus.STOPPED, "the survey stops")


def candidates(folder: Path) -> None:
    """Take pictures of the places to check of a survey, and of where a mine could hide."""
    scene = f"scene:={Path(__file__).resolve().parents[2] / SCENE}"
    with simulated_robot(scene, "time_scale:=50") as robot, shown_window(robot.data) as shown:
        result, operator = shown.window.result.result, Operator()
        wait(lambda: shown.window.survey.snapshot.can_start, "the robot is ready")
        operator.start()
        wait(lambda: operator.code == ControlStatus.FINISHED, "the survey ends")
        wait(lambda: result.record is not None, "the survey is read")
        result.set_permittivity(PERMITTIVITY)
        wait(lambda: result.permittivity == PERMITTIVITY, "the permittivity is stored")

        def end(job: Job) -> None:
            wait(lambda: job.state in (JobState.DONE, JobState.FAILED), "the search ends")
            if job.problem is not None:
                raise SystemExit(f"no result: {job.problem}")

        def hide() -> None:
            result.choose_target(Targets.TYPE_72)
            end(result.hiding)

        shown.take(folder / "candidates", lambda: end(result.search))
        shown.take(folder / "hidden", hide)


def replay(folder: Path) -> None:
    """Record a survey, replay it and take pictures of the window."""
    with simulated_robot("time_scale:=50") as robot:
        if robot.client("--x-points=5", "--y-points=5").wait():
            raise SystemExit("the survey did not finish")
        (survey,) = (path.parent for path in robot.data.glob("*/survey.json"))
        robot.stop()
        port = free_port()
        os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
        replayed = ("rosrun", "gpr20_analysis", "replay", "--ns", "/", str(survey))
        with running("roscore", "-p", str(port)), shown_window(
            robot.data, replay=True
        ) as shown, running(*replayed):
            live = shown.window.traces.live
            wait(lambda: live.radar.count >= REPLAYED, "traces are shown")
            shown.window.show_tab(TabName.ROBOT)
            shown.take(folder / "replay")


def view(folder: Path) -> None:
    """Open the sample survey in gpr20 view, pick the first candidates and take a picture."""
    width, height = viewer.SIZE_PX
    with virtual_screen(f"{width + 40}x{height + 80}x24"), tempfile.TemporaryDirectory() as place:
        application = QApplication([])
        session = ViewSession(load_survey(sample_survey()), ImageOptions())
        picks = PicksFile(Path(place) / "survey.picks.json", SurveyIdentity.of(session.survey))
        shown = viewer.MainWindow(session, PicksTab(picks, "", lambda: ""), sample_survey().name)
        shown.show()
        wait(lambda: shown.image is not None, "the image is there")
        for one in shown.image.candidates.candidates[2::-1] if shown.image else ():
            shown.move_to(Place(one.x_m, one.y_m, one.depth_m))
            shown.pick()
        save(shown, folder / "view_en.png")
        shown.close()
        # Before its screen is gone.
        sip.delete(application)
