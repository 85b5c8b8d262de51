"""What the node of the height sensor answers and publishes, without a graph."""

import math
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest
from test_height_driver import GROUND, NOW_US, code_at, driver_with

pytest.importorskip("rospy")
pytest.importorskip("gpr20_msgs.srv")
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20/test/unit"))

from graph_in_process import Graph
from sensor_msgs.msg import Range

from gpr20_common.high.answers import message_from
from gpr20_common.high.diagnostics import ERROR, OK, WARN
from gpr20_common.low.clock import Clock
from gpr20_common.mid.node_facts import Hardware
from gpr20_height_sensor import adc_interface, height_node
from gpr20_height_sensor.height_driver import HeightParameters
from gpr20_survey.faults import HEIGHT_NOT_MEASURED, NO_GROUND, SENSOR_FAILED


@pytest.fixture
def node(monkeypatch):
    """Return what builds a node over a converter that gives these codes, and is a part of it."""

    def build(*codes):
        graph = Graph(monkeypatch)
        height_node.HeightNode(driver_with(codes)[0], Hardware("sensor"))
        return graph

    return build


GOOD = [GROUND] * 5


def test_a_height_is_answered_with_its_spread_and_voltage_and_published_in_metres(node):
    built = node(*GOOD, *GOOD)
    answer = built.ask("get_height")
    assert answer.success and answer.height_m == pytest.approx(0.2, abs=0.001)
    assert (answer.spread_m, answer.voltage_v) == pytest.approx((0.0, 3.3 * GROUND / 1024))
    built.ticks[0]()
    (message,) = built.published["measured_height"]
    assert message.range == pytest.approx(0.2, abs=0.001)
    assert message.radiation_type == Range.INFRARED
    assert message.header.frame_id == "height_sensor_link"
    assert message.header.stamp.to_nsec() == 1000 * NOW_US
    assert (message.min_range, message.max_range) == pytest.approx((0.10, 0.80))


@pytest.mark.parametrize("code, fault", [(1023, SENSOR_FAILED), (code_at(1.6), NO_GROUND)])
def test_no_height_is_no_number_and_says_why_also_in_the_topic_and_the_diagnostics(
    node, code, fault
):
    built = node(*[code] * 10, *GOOD)
    assert built.health()[1].fault_code == HEIGHT_NOT_MEASURED.code
    assert built.health()[0] == WARN
    answer = built.ask("get_height")
    assert not answer.success and math.isnan(answer.height_m) and math.isnan(answer.spread_m)
    assert answer.fault.code == message_from(answer).fault_code == fault.code
    assert answer.voltage_v == pytest.approx(3.3 * code / 1024)
    built.ticks[0]()
    assert math.isnan(built.published["measured_height"][-1].range)
    level, message, _values = built.health()
    assert (level, message.fault_code) == (ERROR, fault.code)
    built.ticks[0]()
    assert math.isfinite(built.published["measured_height"][-1].range)
    assert built.health()[0] == OK


def test_a_bus_that_does_not_return_ends_the_process(monkeypatch):
    graph, ends, go_on = Graph(monkeypatch), [], threading.Event()
    monkeypatch.setattr(adc_interface, "CALL_LIMIT_S", 0.0)
    monkeypatch.setattr(height_node.os, "_exit", ends.append)
    bus = SimpleNamespace(xfer2=lambda _values: go_on.wait(60.0) and [0, 0, 0])
    height_node.build_height_node(HeightParameters(), bus, Clock(), Hardware("sensor"))
    graph.ticks[0]()
    assert ends == []
    asking = threading.Thread(target=graph.ask, args=("get_height",))
    asking.start()
    while not ends:
        graph.ticks[0]()
    go_on.set()
    asking.join()
    assert set(ends) == {1}
