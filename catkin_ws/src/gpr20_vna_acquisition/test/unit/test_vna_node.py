"""What the node of the analyzer answers and reports: its handlers, called without a graph."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest

pytest.importorskip("rospy")
pytest.importorskip("gpr20_msgs.srv")
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20/test/unit"))

from driver_bench import ADDRESS, POINTS, STARTED_US, SWEEP, Bench, nothing
from graph_in_process import Graph
from socket_vna import SocketVna

from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.high.answers import message_from
from gpr20_common.high.diagnostics import ERROR, OK, WARN
from gpr20_common.mid.node_facts import Hardware
from gpr20_simulator.mid.analyzer.simulated_analyzer import StepTime
from gpr20_survey.faults import CAN_RESUME, NOT_CALIBRATED, VNA_DOUBTFUL
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.high import vna_node
from gpr20_vna_acquisition.mid import exchanges
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

OWN = {"if_bandwidth_hz": 10_000.0, "averages": 1, "output_power": "HIGH"}
GRID = {"start_frequency_hz": 600e6, "stop_frequency_hz": 6e9, "points": POINTS}


@pytest.fixture
def bench():
    return Bench(max_level_db=0.0)


@pytest.fixture
def graph(monkeypatch, bench):
    graph = Graph(monkeypatch)
    vna_node.VNANode(bench.driver, Hardware("analyzer"))
    return graph


@pytest.fixture
def set_up(graph):
    assert graph.ask("connection", connect=True, address=ADDRESS).success
    return graph.ask("freq_sweep_setup", **GRID, **OWN)


def fault_of(answer):
    assert not answer.success and message_from(answer).fault_code == answer.fault.code
    return answer.fault.code


def taken(message, names):
    return {name: getattr(message, name) for name in names}


def test_nothing_is_answered_before_its_time(graph, bench):
    services = ("get_data", "get_freq", "confirm_data", "get_calibration_status")
    for service in services:
        assert fault_of(graph.ask(service)) == errors.NOT_CONNECTED.code
    level, message, _values = graph.health()
    assert (level, message.cause) == (WARN, errors.NOT_CONNECTED.as_note())
    refused = graph.ask("connection", connect=True, address="1.2.3.256")
    assert fault_of(refused) == NOT_ALLOWED.code
    connected = graph.ask("connection", connect=True, address=ADDRESS)
    assert connected.success and connected.identity.startswith("Anritsu,MS2026C/2,SIMULATED")
    assert fault_of(graph.ask("get_data")) == errors.NOT_CONNECTED.code
    assert graph.health()[0] == OK
    assert graph.ask("connection", connect=False).success and bench.open_links == 0


def test_a_set_up_answers_what_the_instrument_took_and_how_long_a_sweep_takes(graph, bench, set_up):
    assert taken(set_up, GRID) == GRID and taken(set_up, OWN) == OWN
    assert set_up.sweep_duration_s == bench.driver.trace_duration_s > 0.0
    assert set_up.request_limit_s == bench.driver.answered_within_s
    assert list(graph.ask("get_freq").frequency_hz) == SWEEP.frequencies_hz().tolist()
    calibration = graph.ask("get_calibration_status")
    assert (calibration.accepted, calibration.status) == (True, calibration.HIGH)
    bench.is_like(calibration_accuracy=0)
    calibration = graph.ask("get_calibration_status")
    assert calibration.success and not calibration.accepted
    assert calibration.fault.code == NOT_CALIBRATED.code


def test_each_request_gets_one_new_sweep_with_its_time_that_is_confirmed_once(graph, bench, set_up):
    frequency_hz = SWEEP.frequencies_hz()
    for confirm_later in (True, False, True):
        before = bench.number
        data = graph.ask("get_data", confirm_later=confirm_later)
        assert data.success and taken(data, OWN) == OWN
        assert list(data.frequency_hz) == frequency_hz.tolist()
        assert list(data.s21_real) == [before + 1.0] * POINTS
        assert data.s21_imag == pytest.approx(frequency_hz / 1e9)
        assert data.sweep_started.to_nsec() == 1000 * STARTED_US < data.sweep_ended.to_nsec()
        assert bool(data.number) is confirm_later
        # Its numbers are larger than any measurement's, which is remarked.
        assert len(data.quality) == 1
        level, message, _values = graph.health()
        assert (level, message.fault_code) == (WARN, VNA_DOUBTFUL.code)
    confirmed = graph.ask("confirm_data", number=data.number)
    assert confirmed.success and confirmed.temperature_c == 40.0
    again = graph.ask("confirm_data", number=data.number)
    assert (fault_of(again), again.repeat) == (CAN_RESUME.code, True)
    bench.is_like(calibration_accuracy=0)
    refused = graph.ask("confirm_data", number=graph.ask("get_data", confirm_later=True).number)
    assert (fault_of(refused), refused.repeat) == (NOT_CALIBRATED.code, False)


def test_an_analyzer_that_is_gone_is_reported_until_it_is_back_and_released_at_the_end(
    graph, bench, set_up
):
    def idle():
        bench.clock.sleep_until_s(bench.clock.now_s() + bench.values.link_check_s)
        graph.ticks[0]()
        return graph.health()

    bench.lose_links()
    level, _message, values = idle()
    assert (level, values["linked"], values["address"]) == (ERROR, False, ADDRESS)
    bench.before = nothing
    level, _message, values = idle()
    assert (level, values["linked"], values["last error"]) == (OK, True, "")
    for hook in graph.hooks:
        hook()
    assert bench.open_links == 0


class Hangs(SocketVna):
    """Does not even let itself be made."""

    go_on = threading.Event()

    def __init__(self, *given, **options):
        self.go_on.wait(60.0)
        super().__init__(*given, **options)


def test_a_call_that_does_not_return_is_reported_and_ends_the_process(monkeypatch):
    graph, clock, ends = Graph(monkeypatch), StepTime(), []
    said, ended = [], threading.Event()
    monkeypatch.setattr(vna_node, "Clock", lambda: clock)
    monkeypatch.setattr(vna_node.rospy, "logfatal", said.append)
    monkeypatch.setattr(exchanges.os, "_exit", ends.append)
    named = {"analyzer": f"{__name__}:Hangs", "analyzer_options": {"port": 1}}
    given = VnaParameters(**named), lambda _address: None, Hardware("analyzer")

    def build():
        vna_node.build_vna_node(*given)
        ended.set()

    threading.Thread(target=build, daemon=True).start()
    while not ends:
        # It must be late twice in a row: once it is after a pause of the whole process, too.
        clock.sleep_until_s(clock.now_s() + 30.0)
        if graph.ticks:
            graph.ticks[0]()
            assert not ended.is_set()
    assert ends == [1] and f"{__name__}:Hangs.__init__ does not return" in said[0]
    Hangs.go_on.set()
    assert ended.wait(30.0)
