"""The candidates of a finished survey in the window."""

from __future__ import annotations

from pathlib import Path

from robot_kit import simulated_robot
from window_kit import Operator

from gpr20_msgs.msg import ControlStatus
from gpr20_operator.jobs.search import SearchState
from gpr20_user_interface.window.rail import TabName
from pictures.kit import shown_window, wait

SCENE = "imaging_targets.yaml"
PERMITTIVITY = "5"  # of the scene
ENDED = (SearchState.DONE, SearchState.FAILED)


def make(folder: Path) -> None:
    """Search for candidates in each language and take pictures of the lists."""
    scenes = Path(__file__).resolve().parents[2] / "catkin_ws/src/gpr20_simulator/scenes"
    with simulated_robot(f"scene:={scenes / SCENE}", "time_scale:=50") as robot, shown_window(
        robot.data
    ) as shown:
        window, operator = shown.window, Operator()
        wait(lambda: window.survey.snapshot.can_start, "the robot is ready")
        operator.start()
        wait(lambda: operator.code == ControlStatus.FINISHED, "the survey ends")
        window.show_tab(TabName.SURVEYS)
        wait(lambda: window.past.table.rowCount() == 1, "the list is there")
        window.past.table.selectRow(0)
        wait(window.past.candidates.isEnabled, "the survey can be searched")
        window.past.candidates.click()
        window.candidates.permittivity.setText(PERMITTIVITY)

        def find() -> None:
            window.candidates.find_button.click()
            wait(lambda: window.candidates.search.state in ENDED, "the search ends")
            if window.candidates.search.state is SearchState.FAILED:
                raise SystemExit(f"no candidates: {window.candidates.search.problem}")

        def hide() -> None:
            window.show_tab(TabName.SURVEYS)
            surveys = window.tabs.currentIndex()
            window.past.candidates.click()
            find()
            window.candidates.hiding_button.click()
            wait(lambda: window.candidates.search.state in ENDED, "the map ends")
            window.candidates.close_button.click()
            window.past.open.click()
            wait(lambda: window.tabs.currentIndex() != surveys, "the survey is open")
            window.show_tab(TabName.GROUND)

        shown.take(folder, "candidates", find)
        shown.take(folder, "hidden", hide)
