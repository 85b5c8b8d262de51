"""Nodes that are lost: the survey waits, and continues or pauses."""

import threading

import pytest
from fake_robot import LIMIT_S, NODES, reports
from fault_kit import raises_fault

from gpr20_common.faults import BUSY, INTERNAL, PART_RED, PART_SILENT
from gpr20_common.message import Message
from gpr20_main_control.errors import RequestRefusedError
from gpr20_main_control.mid.waits import Workers
from gpr20_survey.plan.survey_state import SurveyState as State

VNA, STORAGE, X_AXIS = "vna_acquisition", "vna_processing", "x_axis/axis_driver"


def lose(bench, node, after):
    """Let a node die at the beginning of a sweep, once."""
    bench.at_sweep(after, lambda: bench.nodes.note_silent(node))


def come_back(bench, node):
    bench.nodes.note_alive(node, 2)


@pytest.mark.parametrize("node", [VNA, STORAGE, X_AXIS])
def test_a_survey_holds_while_a_node_is_gone_and_goes_on_by_itself(bench, node):
    lose(bench, node, after=5)
    bench.start()
    bench.wait_for_fault(PART_SILENT.as_warning(), NODES[node])
    assert bench.board.status.state is State.CHECKING
    connections = len(bench.analyzer.connections)
    shown = bench.board.status.full_message
    assert PART_SILENT.as_warning() in shown.faults
    assert reports(shown.values["warning"], PART_SILENT, NODES[node])
    assert shown.all_details == (node,)
    assert all(axis.stops > 0 for axis in bench.axes)
    come_back(bench, node)
    bench.complete()
    assert len(bench.analyzer.connections) > connections
    assert "PAUSED" not in bench.states
    assert bench.board.status.full_message.fault_code == ""


@pytest.mark.parametrize("after, end", [(0, State.FAILED), (5, State.PAUSED)])
def test_a_node_that_stays_away_fails_the_survey_before_anything_moves_or_pauses_it(
    make_bench, after, end
):
    bench = make_bench(return_limit_s=300.0)
    if after:
        lose(bench, VNA, after)
    else:
        bench.nodes.note_silent(VNA)
    bench.start()
    assert reports(bench.wait_for(end).message, PART_RED, NODES[VNA], 300.0)
    if after:
        come_back(bench, VNA)
        bench.resume_to_the_end()
    else:
        assert all(axis.moves == [] and axis.homings == 0 for axis in bench.axes)


def test_a_node_that_dies_again_and_again_pauses_the_survey(bench):
    deaths = []

    def die():
        if bench.analyzer.sweeps >= 5:
            deaths.append(VNA)
            bench.nodes.note_silent(VNA)
            bench.nodes.note_alive(VNA, 1 + len(deaths))

    bench.analyzer.on_sweep = die
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert reports(status.message, INTERNAL, NODES[VNA], 4)
    bench.analyzer.on_sweep = lambda: None
    bench.resume_to_the_end()


def test_a_node_that_dies_while_the_survey_is_paused_is_named_and_it_stays_paused(bench):
    bench.at_sweep(2, bench.control.pause)
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.nodes.note_silent(STORAGE)
    shown = bench.board.status.full_message
    assert reports(shown.values["warning"], PART_SILENT, NODES[STORAGE])
    come_back(bench, STORAGE)
    assert bench.board.status.missing is None
    assert bench.states[-1] == "PAUSED"
    bench.resume_to_the_end()


def die_after(bench, call):
    """Let the storage die after it has carried out a call, once, and wait for it."""
    usual = getattr(bench.storage, call)

    def act_and_die(*given):
        setattr(bench.storage, call, usual)
        usual(*given)
        bench.nodes.note_silent(STORAGE)
        bench.nodes.check()

    setattr(bench.storage, call, act_and_die)
    bench.start()
    bench.wait_for_fault(PART_SILENT.as_warning(), NODES[STORAGE])


def test_a_storage_that_ended_the_survey_and_died_is_believed_when_it_is_back(bench):
    die_after(bench, "close")
    bench.storage.broken = True
    come_back(bench, STORAGE)
    bench.complete()


def test_an_opening_whose_answer_was_lost_is_repeated_as_it_was(bench):
    die_after(bench, "open")
    come_back(bench, STORAGE)
    bench.complete()
    first, second = bench.storage.records
    assert first == second


def test_a_request_that_takes_long_does_not_hang_the_next_one(bench, monkeypatch):
    monkeypatch.setattr("gpr20_main_control.mid.main_control.REQUEST_LIMIT_S", 0.05)
    opening, opened = threading.Event(), threading.Event()

    def open_slowly(_survey):
        opening.set()
        assert opened.wait(LIMIT_S)
        raise RequestRefusedError(Message("there is none"))

    monkeypatch.setattr(bench.storage, "reopen", open_slowly)
    resuming = Workers().begin(lambda: bench.control.resume("survey"))
    assert opening.wait(LIMIT_S)
    with raises_fault(BUSY, error=RequestRefusedError):
        bench.start()
    opened.set()
    assert isinstance(resuming.exception(LIMIT_S), RequestRefusedError)
