"""The tutorial docs/extend/axis_controller.md, and the contract that pins and controllers keep."""

import dataclasses
import sys
import tempfile
from pathlib import Path

import pytest
from axis_machine import SHORT, X_PARAMETERS
from case_kit import each_case
from fault_kit import raises_fault
from line_drive import LineDrive
from tutorial_code import code_blocks
from wait_kit import wait_until

from gpr20_axis_driver import controller
from gpr20_axis_driver.controller import ControllerError, open_axis
from gpr20_common.errors import InvalidValueError
from gpr20_survey.faults import AXIS_MAY_MOVE, NOT_HOMED

PAGE = Path(__file__).parents[5] / "docs/extend/axis_controller.md"
# The modules of the page, importable as a package of their own would be.
_folder = tempfile.TemporaryDirectory()
for _name, _code in code_blocks(PAGE, "python").items():
    Path(_folder.name, _name).write_text(_code)
sys.path.insert(0, _folder.name)

from test_line_axis import TestLineController  # noqa: E402, F401


@each_case(
    "controller, options, error",
    [
        ("no_such_module:Axis", {}, "no_such_module.*ModuleNotFoundError"),
        ("subprocess:Popen", {"args": "true"}, "AxisController.*begin_homing"),
        ("line_axis:LineController", {}, "controller_options.*'host'"),
        ("line_axis:LineController", {"host": "x", "baud": 9600}, "'baud'"),
    ],
)
def test_a_controller_that_cannot_be_used_is_refused_with_the_reason(controller, options, error):
    named = {"controller": controller, "controller_options": options}
    with pytest.raises(InvalidValueError, match=error):
        open_axis(dataclasses.replace(X_PARAMETERS, **named))


@pytest.fixture
def driven():
    """A driver over the controller of the page, homed, and its drive."""
    drive = LineDrive()
    options = {"host": "127.0.0.1", "port": drive.port}
    named = {"controller": "line_axis:LineController", "controller_options": options}
    parameters = dataclasses.replace(SHORT, **named)
    driver = open_axis(parameters)
    driver.homing()
    yield driver, drive
    drive.answering.set()
    driver.close(1.0)
    drive.close()
    # One that cannot be reached is an error at the start.
    with raises_fault(AXIS_MAY_MOVE, error=ControllerError):
        open_axis(parameters)


def test_a_controller_that_rests_elsewhere_than_it_should_must_be_homed(driven):
    driver, drive = driven
    drive.lost_steps = 1
    with raises_fault(NOT_HOMED, "5 mm", "4.99 mm"):
        driver.move_to_coordinate(5.0)
    assert not driver.homing_done
    driver.homing()
    assert driver.homing_done


@pytest.mark.parametrize("change", [{"homed": False}, {"plugged": False}])
def test_a_controller_that_was_restarted_or_fails_at_rest_is_reported(driven, change):
    driver, drive = driven
    vars(drive).update(change)
    wait_until(lambda: driver.failure is not None and not driver.homing_done)
    may_move = "plugged" in change
    assert driver.failure.fault_code == (AXIS_MAY_MOVE if may_move else NOT_HOMED).code
    assert driver.failure.may_move is may_move


def test_a_call_that_does_not_return_is_overdue_until_it_does(driven, monkeypatch):
    driver, drive = driven
    monkeypatch.setattr(controller, "CALL_LIMIT_S", 0.1)
    drive.answering.clear()
    wait_until(lambda: driver.motions.overdue)
    with raises_fault(AXIS_MAY_MOVE, error=ControllerError):
        driver.move_to_coordinate(5.0)
    assert not driver.motions.overdue and driver.failure.may_move
    drive.answering.set()
    driver.homing()
    # The drive has read all by now: a command that had to wait was not sent late.
    assert drive.moves == 0
