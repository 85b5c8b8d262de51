"""The faults that the status reports: what decides, how grave it is, and whether things move."""

import threading
from dataclasses import replace

import pytest
from fake_robot import LIMIT_S, reports, warning_of

from gpr20_common.faults import PART_SILENT
from gpr20_common.message import Message, Severity
from gpr20_common.mid.node_facts import NodeSoftware
from gpr20_main_control.errors import (
    UnconfirmedError,
)
from gpr20_survey.faults import CLOCK_WRONG, TAKES_LONG, VNA_FAILED
from gpr20_survey.plan.survey_state import SurveyState as State

VNA = "vna_acquisition"


def severities(message):
    return {fault.severity for fault in message.faults}


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
    assert {CLOCK_WRONG.as_warning().code, VNA_FAILED.code} <= codes
    assert PART_SILENT.as_warning().code in codes
    warnings = [warning_of(one) for one in bench.storage.reports[-1]["warnings"]]
    assert len(warnings) == 3
    assert {one.cause.severity for one in warnings} == {Severity.WARNING}


# What is waited for.


def waits_for(bench, *shown):
    """Whether the status says that it waits, and what for: shown are the names and the point."""
    message = bench.board.status.full_message
    return reports(message, TAKES_LONG) and all(one in str(message) for one in shown)


@pytest.mark.parametrize(
    "part, call, index, shown",
    [
        ("analyzer", "sweep", 3, ("the VNA: sweep", "point 3,")),
        ("analyzer", "confirm", 3, ("the VNA: settings", "point 3,")),
        ("analyzer", "connect", 0, ("the VNA: connection,",)),
        ("height", "height_m", 4, ("the height sensor: height", "point 3,")),
    ],
)
def test_a_call_that_takes_long_is_shown_until_it_ends(bench, part, call, index, shown):
    """One real second is a thousand for the survey."""
    hang, calls = threading.Event(), []
    device = getattr(bench, part)
    usual = getattr(device, call)

    def hang_once(*arguments):
        calls.append(arguments)
        if len(calls) == index + 1:
            hang.wait(LIMIT_S)
        return usual(*arguments)

    setattr(device, call, hang_once)
    bench.start()
    bench.wait_until(lambda: waits_for(bench, *shown))
    assert bench.board.status.state is (State.CHECKING if index == 0 else State.SURVEYING)
    hang.set()
    bench.complete()
    assert not waits_for(bench)
