import sys
from pathlib import Path

import pytest
from robot_in_process import RobotInProcess
from simulated_world import World

SOURCES = Path(__file__).resolve().parents[3]
# The examples of the surveys, the window and the page.
for package in ("survey", "analysis", "operator", "user_interface", "web"):
    sys.path.append(str(SOURCES / f"gpr20_{package}" / "test" / "unit"))


@pytest.fixture
def world(tmp_path):
    """Carriage, ground, instrument and disk of a simulated robot."""
    return World(tmp_path)


@pytest.fixture
def robot(world):
    """The robot in one process."""
    robot = RobotInProcess(world)
    yield robot
    robot.close()
