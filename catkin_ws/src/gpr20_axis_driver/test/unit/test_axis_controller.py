"""The tutorial docs/extend/axis_controller.md, and the contract that pins and controllers keep."""

import dataclasses
import sys
import tempfile
import threading
import time
from pathlib import Path

import pytest
from axis_machine import SHORT, X_PARAMETERS
from case_kit import each_case
from fault_kit import raises_fault
from grbl_board import GrblBoard
from simulated_axis import wait_until
from tutorial_code import code_blocks

from gpr20_axis_driver.axis_exceptions import AxisException
from gpr20_axis_driver.controller import ControllerError, ControllerState
from gpr20_axis_driver.mid import controller_motions
from gpr20_axis_driver.mid.controller_motions import ControllerMotions
from gpr20_axis_driver.mid.controllers import (
    check_controller,
    controller_driver,
    open_controller,
)
from gpr20_common.errors import InvalidValueError
from gpr20_survey.faults import AXIS_MAY_MOVE, NOT_HOMED

PAGE = Path(__file__).parents[5] / "docs/extend/axis_controller.md"
# The modules of the page, importable as a package of their own would be.
_folder = tempfile.TemporaryDirectory()
for _name, _code in code_blocks(PAGE, "python").items():
    Path(_folder.name, _name).write_text(_code)
sys.path.insert(0, _folder.name)

from test_grbl_axis import TestGrblController  # noqa: E402, F401


@each_case(
    "controller, options, error",
    [
        ("no_such_module:Axis", {}, "no_such_module.*ModuleNotFoundError"),
        ("subprocess:Popen", {"args": "true"}, "AxisController.*begin_homing"),
        ("grbl_axis:GrblController", {}, "controller_options.*'host'"),
        ("grbl_axis:GrblController", {"host": "x", "baud": 9600}, "'baud'"),
    ],
)
def test_a_controller_that_cannot_be_used_is_refused_with_the_reason(controller, options, error):
    parameters = dataclasses.replace(
        X_PARAMETERS, controller=controller, controller_options=options
    )
    with pytest.raises(InvalidValueError, match=error):
        open_controller(parameters)


def parameters_of(board):
    return dataclasses.replace(
        X_PARAMETERS,
        controller="grbl_axis:GrblController",
        controller_options={"host": "127.0.0.1", "port": board.port},
    )


def test_a_move_ends_by_itself_when_nobody_asks_for_the_state_any_more():
    board = GrblBoard()
    parameters = parameters_of(board)
    controller = check_controller(parameters)(parameters, **parameters.controller_options)
    controller.begin_homing()
    wait_until(lambda: not controller.read().moving)
    controller.begin_move(60000)
    wait_until(lambda: controller.read().steps > 50)

    def rests():
        before = board.true_steps
        time.sleep(0.2)
        return board.true_steps == before

    # What was sent in advance takes half a second; the rest of the move would take minutes.
    wait_until(rests)
    assert board.true_steps < 1000
    controller.close()
    board.close()
    # One that does not answer is an error at the start.
    with raises_fault(AXIS_MAY_MOVE, error=ControllerError):
        open_controller(parameters)


class ScriptedController:
    """Does what a test says: `moves` and `homes` are the states that follow a command."""

    name = "scripted"

    def __init__(self, _parameters):
        self.state = ControllerState(0, moving=False, homed=False)
        self.states = []
        self.homes = [ControllerState(0, True, False), ControllerState(0, False, True)]
        self.moves = []
        self.stopped = 0

    def read(self):
        if self.states:
            self.state = self.states.pop(0)
        if isinstance(self.state, Exception):
            raise self.state
        return self.state

    def begin_homing(self):
        self.states = list(self.homes)

    def begin_move(self, _steps):
        self.states = list(self.moves)

    def stop(self):
        self.stopped += 1
        self.states = []
        self.state = ControllerState(self.state.steps, False, self.state.homed)

    def close(self):
        raise OSError("the link is broken")


@pytest.fixture
def scripted():
    made = []

    def make(parameters):
        made.append(ScriptedController(parameters))
        return made[-1]

    driver = controller_driver(SHORT, ControllerMotions(SHORT, make))
    driver.homing()
    yield driver, made
    driver.close(1.0)


def test_a_controller_that_rests_elsewhere_than_it_should_must_be_homed(scripted):
    driver, made = scripted
    made[0].moves = [ControllerState(499, True, True), ControllerState(499, False, True)]
    with raises_fault(NOT_HOMED, "5 mm", "4.99 mm"):
        driver.move_to_coordinate(5.0)
    assert not driver.homing_done
    driver.homing()
    assert driver.homing_done and len(made) == 2


@pytest.mark.parametrize(
    "state, fault",
    [
        (ControllerState(0, False, False), NOT_HOMED),
        (ZeroDivisionError("in a class that is not ours"), AXIS_MAY_MOVE),
    ],
)
def test_a_controller_that_was_restarted_or_fails_at_rest_is_reported(scripted, state, fault):
    driver, made = scripted
    made[0].state = state
    wait_until(lambda: driver.failure is not None and not driver.homing_done)
    assert driver.failure.fault_code == fault.code
    assert driver.failure.may_move is isinstance(state, Exception)


@pytest.mark.parametrize("method", ["stop", "read"])
def test_a_controller_that_hangs_in_any_method_is_an_error_in_time(scripted, monkeypatch, method):
    driver, made = scripted
    monkeypatch.setattr(controller_motions, "CALL_LIMIT_S", 0.2)
    go_on, returned = threading.Event(), threading.Event()
    made[0].moves = [ControllerState(100, True, True)] * 1000
    setattr(made[0], method, lambda *_: (go_on.wait(60.0), returned.set()))
    if method == "read":
        wait_until(lambda: driver.failure is not None)  # at rest, too
    try:
        with pytest.raises(AxisException) as refused:
            driver.move_to_coordinate(5.0, lambda: True)
        expected = AXIS_MAY_MOVE.code
        assert refused.value.message.fault_code in (expected, NOT_HOMED.code)
        assert driver.failure.fault_code == expected
        with raises_fault(AXIS_MAY_MOVE, error=ControllerError):
            driver.homing()
    finally:
        go_on.set()
    # A command that had to wait is not carried out late.
    assert returned.wait(30.0)
    assert bool(made[0].states) is (method == "stop")
