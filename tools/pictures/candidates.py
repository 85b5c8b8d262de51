"""The result of a finished survey in the window."""

from __future__ import annotations

from pathlib import Path

from robot_kit import simulated_robot
from window_kit import Operator

from gpr20_msgs.msg import ControlStatus
from gpr20_operator.jobs.job import Job, JobState
from gpr20_survey.results.hidden_target import Targets
from pictures.kit import shown_window, wait

SCENE = "imaging_targets.yaml"
PERMITTIVITY = 5.0  # of the scene


def make(folder: Path) -> None:
    """Search in each language, and take pictures of the places and of where a mine could hide."""
    scenes = Path(__file__).resolve().parents[2] / "catkin_ws/src/gpr20_simulator/scenes"
    with simulated_robot(f"scene:={scenes / SCENE}", "time_scale:=50") as robot, shown_window(
        robot.data
    ) as shown:
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

        shown.take(folder, "candidates", lambda: end(result.search))
        shown.take(folder, "hidden", hide)
