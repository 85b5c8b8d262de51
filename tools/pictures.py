"""Make groups of pictures of the documentation; started by scripts/pictures.sh."""

from __future__ import annotations

import argparse
import contextlib
import functools
import io
import multiprocessing
import os
import subprocess
import tempfile
from pathlib import Path
from typing import Callable, Dict, Iterator, NamedTuple, Tuple

import numpy as np
import rosgraph
import rospy
from PIL import Image
from PyQt5 import sip
from PyQt5.QtWidgets import QApplication, QWidget
from robot_kit import free_port, running, simulated_robot
from window_kit import Operator, new_window, run_events, run_until, virtual_screen

from gpr20_analysis import (
    ImageOptions,
    find_candidates,
    image_survey,
    load_survey,
    process_survey,
    sample_survey,
)
from gpr20_analysis.commands import main as program
from gpr20_analysis.plotting.maps import candidate_map_figure
from gpr20_analysis.sample import REAL_LINE_FILE
from gpr20_common import catalogue
from gpr20_common.catalogue import Language
from gpr20_msgs.msg import ControlStatus
from gpr20_operator.ground.sources import Layer
from gpr20_operator.jobs.job import Job, JobState
from gpr20_survey.results.hiding_map import Targets
from gpr20_user_interface.look.translation import Languages
from gpr20_user_interface.widgets.bars import TabName
from gpr20_user_interface.window.main_window import MainWindow
from gpr20_viewer.picks_file import PicksFile, SurveyIdentity
from gpr20_viewer.positions import Place
from gpr20_viewer.session import ViewSession
from gpr20_viewer.views import main_window as viewer
from gpr20_viewer.views.tables import PicksTab

# Of the simulated soil of the sample, and of the concrete of the real line.
PERMITTIVITY, REAL_PERMITTIVITY = "5", "6"
FEWEST_LINES, FRAME_MS, PAUSE_MS = 3, 250, 3500
DEEPEST_MM = 160.0
REPORT_PX, BROWSER_LIMIT_S = (1100, 1500), 120.0


def animation(folder: Path) -> None:
    """Show how the image grows with each line, and the places to check at the end."""
    survey = process_survey(load_survey(sample_survey()), "background:method=surface")
    options = ImageOptions(permittivity=float(PERMITTIVITY))
    y_mm, frames = 1000.0 * survey.y.values, []
    for lines in range(FEWEST_LINES, len(y_mm) + 1):
        image = image_survey(survey.isel(y=slice(0, lines)), options)
        found = find_candidates(image).candidates if lines == len(y_mm) else ()
        figure = candidate_map_figure(image, [one for one in found if not one.is_doubtful])
        # Of one size and scale, however many lines there are.
        figure.set_size_inches(6.0, 5.0)
        figure.axes[0].set_ylim(y_mm[-1], y_mm[0])
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=70)
        frames.append(Image.open(stream).convert("RGB"))
    times_ms = [FRAME_MS] * (len(frames) - 1) + [PAUSE_MS]
    path = folder / "survey.webp"
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=times_ms, loop=0)
    print(path)


def real_line(folder: Path) -> None:
    """Image the line by the default command, and mark above it where its bars were published."""
    with tempfile.TemporaryDirectory() as place:
        line, image = (str(Path(place) / name) for name in ("line.nc", "image.nc"))
        _run("sample", "--real", line)
        _run("image", line, "--permittivity", REAL_PERMITTIVITY, "-o", image)
        figure = candidate_map_figure(load_survey(image), [])
    figure.set_size_inches(9.0, 3.2)
    figure.suptitle(f"Real line over 14 reinforcing bars, permittivity {REAL_PERMITTIVITY}")
    axes = figure.axes[0]
    axes.set_aspect("auto")
    axes.set_ylim(DEEPEST_MM, 0.0)
    with np.load(str(REAL_LINE_FILE)) as file:
        bars_mm = file["rebar_x_m"] * 1000.0
    axes.plot(bars_mm, np.full(len(bars_mm), 8.0), "v", color="white", markeredgecolor="black")
    path = folder / "real_line.png"
    figure.savefig(str(path), dpi=100)
    print(path)


def hiding(folder: Path) -> None:
    """Draw the map of where a mine could hide."""
    options = ("--permittivity", PERMITTIVITY, "--rounds", "24")
    _run("hiding", str(sample_survey()), *options, "-o", str(folder / "hiding.png"))


def report(folder: Path) -> None:
    """Take a picture of the top of a report in each language, by a browser."""
    width, height = REPORT_PX
    for language in catalogue.languages():
        picture = folder / f"report_{language.value}.png"
        with tempfile.TemporaryDirectory() as place:
            page = Path(place) / "report.html"
            options = ("--permittivity", PERMITTIVITY, "--language", language.value)
            _run("report", str(sample_survey()), "-o", str(page), *options)
            browser = ["chromium", "--headless", "--no-sandbox", "--disable-gpu"]
            browser += ["--hide-scrollbars", f"--window-size={width},{height}"]
            browser += [f"--screenshot={picture}", page.as_uri()]
            subprocess.run(browser, check=True, capture_output=True, timeout=BROWSER_LIMIT_S)
        print(picture)


def _run(*arguments: str) -> None:
    if program.main([*arguments]):
        raise SystemExit(f"gpr20 {arguments[0]} has failed")


SCENE = "catkin_ws/src/gpr20_simulator/scenes/imaging_targets.yaml"
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
    scene = f"scene:={Path(__file__).resolve().parents[1] / SCENE}"
    with simulated_robot(scene, "time_scale:=50") as robot, shown_window(robot.data) as shown:
        result, operator = shown.window.result.result, Operator()
        wait(lambda: shown.window.survey.snapshot.can_start, "the robot is ready")
        operator.start()
        wait(lambda: operator.code == ControlStatus.FINISHED, "the survey ends")
        wait(lambda: result.record is not None, "the survey is read")
        result.set_permittivity(float(PERMITTIVITY))
        wait(lambda: result.permittivity == float(PERMITTIVITY), "the permittivity is stored")

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
            shown.window.show_tab(TabName.GROUND)
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


DOCS_IMAGES = Path(__file__).resolve().parents[1] / "docs/images"
# What each function makes.
GROUPS: Dict[str, Tuple[Callable[[Path], None], str]] = {
    "animation": (animation, "the image of the sample survey, line by line"),
    "real_line": (real_line, "the image of the real line"),
    "report": (report, "a report of the sample survey"),
    "hiding": (hiding, "where a mine could hide in the sample survey"),
    "window": (window, "every tab of the window during a survey, in 800x480"),
    "candidates": (candidates, "the candidates of a survey in the window"),
    "replay": (replay, "the window during a replay"),
    "view": (view, "gpr20 view of the sample survey"),
}


def main() -> None:
    """Make the groups that are named, or list all."""
    parser = argparse.ArgumentParser(
        prog="scripts/pictures.sh",
        description="\n".join(f"  {name:13} {what}" for name, (_, what) in GROUPS.items()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--into", type=Path, metavar="FOLDER", default=DOCS_IMAGES)
    parser.add_argument("names", nargs="*", metavar="NAME", help="what is made, from the list")
    chosen = parser.parse_args()
    if not chosen.names or not GROUPS.keys() >= set(chosen.names):
        parser.print_help()
        raise SystemExit(2 if chosen.names else 0)
    folder = chosen.into.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for name in chosen.names:
        # A process can be a ROS node, and a Qt application, only once.
        process = multiprocessing.Process(target=GROUPS[name][0], args=(folder,))
        process.start()
        process.join()
        if process.exitcode:
            raise SystemExit(f"{name}: the pictures were not made")


if __name__ == "__main__":
    main()
