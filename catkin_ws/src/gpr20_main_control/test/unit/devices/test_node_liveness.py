"""What is known about the nodes: which are missing, which were restarted."""

from fake_robot import ManualClock
from fault_kit import raises_fault

from gpr20_common.faults import PART_SILENT
from gpr20_common.message import verbatim
from gpr20_main_control.errors import NodeLostError
from gpr20_main_control.mid.devices.node_liveness import START_LIMIT_S, NodeLiveness


class Watched:
    """Two nodes that a test notes, and the messages about those that were missing."""

    def __init__(self):
        self.clock = ManualClock()
        self.reported = []
        self.nodes = NodeLiveness(self.clock, self._note)
        for name in ("x", "y"):
            self.nodes.watch(name, verbatim(name), None)

    def _note(self, message):
        self.reported.append(message and message.all_details)
        assert message is None or message.fault_code == PART_SILENT.code

    def all_alive(self):
        self.nodes.note("x", 1)
        self.nodes.note("y", 2)
        return self.nodes


def test_a_node_is_called_missing_at_once_if_it_was_there_and_otherwise_when_it_had_its_time():
    bench = Watched()
    bench.nodes.note("x", None)
    assert bench.reported == []
    bench.clock.time_s += START_LIMIT_S + 1.0
    bench.nodes.note("x", None)
    assert bench.reported == [("x", "y")]
    nodes = bench.all_alive()
    nodes.note("y", None)
    nodes.note("y", None)
    nodes.note("y", 3)
    assert bench.reported == [("x", "y"), ("y",), None, ("y",), None]


def test_a_node_that_was_restarted_is_lost_until_it_is_accepted():
    nodes = Watched().all_alive()
    nodes.accept()
    nodes.check()
    nodes.note("x", 17)
    with raises_fault(PART_SILENT, "(x)", error=NodeLostError):
        nodes.check()
    nodes.note("y", None)
    assert nodes.lost().all_details == ("y", "x")
    nodes.note("y", 2)
    nodes.accept()
    nodes.check()
