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

from gpr20_axis_driver import controller
from gpr20_axis_driver.controller import (
    ControllerError,
    ControllerMotions,
    ControllerState,
    check_controller,
    open_axis,
)
from gpr20_axis_driver.mid.axis_driver import AxisDriver
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
        open_axis(parameters)


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
        open_axis(parameters)


class ScriptedController:
    """Does what a test says: `moves` and `homes` are the states that follow a command."""

    name = "scripted"

    def __init__(self):
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

    def make():
        made.append(ScriptedController())
        return made[-1]

    motions = ControllerMotions(SHORT, make)
    motions.open()
    driver = AxisDriver(SHORT, motions, motions.home)
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
def test_a_call_that_does_not_return_is_overdue_until_it_does(scripted, monkeypatch, method):
    driver, made = scripted
    monkeypatch.setattr(controller, "CALL_LIMIT_S", 0.1)
    go_on, ended = threading.Event(), threading.Event()
    made[0].moves = [ControllerState(100, True, True)] * 1000

    def hang():
        go_on.wait(60.0)
        raise OSError("the link is broken")

    setattr(made[0], method, hang)

    def move():
        with raises_fault(AXIS_MAY_MOVE, error=ControllerError):
            driver.move_to_coordinate(5.0, lambda: True)
        ended.set()

    if method == "read":
        wait_until(lambda: driver.motions.overdue)  # at rest, too
    threading.Thread(target=move).start()
    wait_until(lambda: driver.motions.overdue)
    go_on.set()
    # A command that had to wait for it is not carried out late.
    assert ended.wait(30.0)
    assert bool(made[0].states) is (method == "stop")
    assert not driver.motions.overdue and driver.failure.may_move
