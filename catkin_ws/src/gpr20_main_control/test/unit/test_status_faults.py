"""The faults that the status reports: what decides, how grave it is, and whether things move."""

from dataclasses import replace

import pytest
from fake_robot import LIMIT_S, NODES, Bench, reports, warning_of

from gpr20_common.faults import INTERNAL
from gpr20_common.message import Fault, Message, Severity
from gpr20_common.mid.node_software import NodeSoftware
from gpr20_main_control import faults
from gpr20_main_control.errors import (
    DeviceError,
    SurveyError,
    UnconfirmedError,
    message_of,
)
from gpr20_survey.plan.survey_state import SurveyState as State

SENSOR_OFF = Fault("height.test_sensor_off", Message("Switch the sensor on."))
VNA = "vna_acquisition"


def severities(message):
    return {fault.severity for fault in message.faults}


def pause_on_request(bench):
    bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 2 and bench.control.pause()
    bench.start()
    message = bench.wait_for(State.PAUSED).message
    bench.analyzer.on_sweep = lambda: None
    return message


def test_a_pause_on_request_is_a_note(bench):
    message = pause_on_request(bench)
    assert message.fault_code == "survey.paused_on_request"
    assert severities(message) == {Severity.NOTE}
    assert not message.may_move


def test_a_warning_does_not_make_a_pause_on_request_a_fault(bench):
    pause_on_request(bench)
    bench.nodes.note_silent(VNA)
    shown = bench.board.status.full_message
    assert severities(shown) == {Severity.NOTE, Severity.WARNING}
    assert faults.PAUSED_ON_REQUEST in shown.faults
    assert reports(shown.values["warning"], faults.NODE_LOST, NODES[VNA])


def test_a_fault_decides_though_a_warning_is_shown_before_it(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.nodes.note_silent(VNA)
    assert bench.board.status.full_message.fault_code == faults.MOVE_FAILED.code


def test_a_fault_of_a_device_pauses_with_the_innermost_code(bench):
    def fail():
        raise DeviceError(Message("no light comes back"), fault=SENSOR_OFF)

    bench.analyzer.on_sweep = lambda: setattr(bench.height, "height_m", fail)
    bench.start()
    message = bench.wait_for(State.PAUSED).message
    assert message.cause == SENSOR_OFF
    assert faults.HEIGHT_NOT_MEASURED in message.faults


def test_a_survey_that_continues_never_shows_a_fault(bench):
    """Different software, a clock that is set, a sweep that is repeated, and a lost node."""
    for node, revision in (("height_sensor", "abc"), (VNA, "def")):
        one = replace(bench.description.nodes[node], software=NodeSoftware("0.1.0", revision, "pc"))
        bench.description.note(one)

    def disturb():
        if bench.analyzer.sweeps == 3:
            bench.clock.set_s -= 1.0e7
        elif bench.analyzer.sweeps == 9:
            bench.nodes.note_silent(VNA)
            bench.nodes.note_alive(VNA, 2)

    refused = {6}

    def confirm(number):
        if number in refused:
            raise UnconfirmedError(Message("changed by hand"), repeat=True)
        return ()

    bench.analyzer.on_sweep, bench.analyzer.on_confirm = disturb, confirm
    bench.start()
    bench.complete()
    shown = [status.full_message for status in bench.history]
    assert {one for message in shown for one in severities(message)} == {Severity.WARNING}
    codes = {fault.code for message in shown for fault in message.faults}
    assert {faults.CLOCK_SET.code, faults.SWEEP_UNCONFIRMED.code} <= codes
    assert faults.WAITING_FOR_PART.code in codes
    warnings = [warning_of(one) for one in bench.storage.reports[-1]["warnings"]]
    assert len(warnings) == 3
    assert {one.cause.severity for one in warnings} == {Severity.WARNING}


@pytest.mark.parametrize("fail_first", [False, True])
def test_an_axis_that_is_still_moving_decides_whatever_else_is_said(bench, fail_first):
    bench.x.blocked.clear()
    if fail_first:
        bench.storage.fail_close = "the disk is full"
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.stop()
    message = bench.wait_for(State.STOPPED).message
    assert message.may_move
    assert message.cause == faults.AXIS_STILL_MOVING
    assert faults.STOPPED_ON_REQUEST in message.faults


def test_a_stop_and_a_shutdown_are_notes():
    bench = Bench()
    bench.start()
    bench.control.stop()
    assert severities(bench.wait_for(State.STOPPED).message) == {Severity.NOTE}
    bench.start()
    bench.control.shut_down(LIMIT_S)
    assert severities(bench.board.status.message) == {Severity.NOTE}


def test_a_fault_in_the_software_has_its_own_code():
    assert message_of(RuntimeError("x")).fault_code == INTERNAL.code
    assert message_of(SurveyError(Message("x"))).fault_code == faults.SURVEY_FAILED.code
