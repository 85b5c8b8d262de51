"""A node that cannot start ends its launch, if the robot is incomplete without it."""

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

from gpr20_common.errors import InvalidValueError, NodeSilentError
from gpr20_common.high import node
from gpr20_common.message import Message

LAUNCH = 4711


class Probe:
    """Finds no other node of the name, or one that lives."""

    other = False

    def __init__(self, *_arguments):
        pass

    def process(self):
        if not self.other:
            raise NodeSilentError(Message("nobody"))
        return 12


@pytest.fixture
def ended(monkeypatch):
    """The launches that a node has ended; each node here is the first of a launch."""
    found = []
    for name in ("init_node", "logfatal", "get_name"):
        monkeypatch.setattr(node.rospy, name, lambda *_all, **_named: "/node")
    # The node sets another one.
    monkeypatch.setattr(node.threading, "excepthook", node.threading.excepthook)
    monkeypatch.setattr(node.rospy, "has_param", lambda _name: False)
    monkeypatch.setattr(node, "configuration_name", lambda: "/launch_1")
    monkeypatch.setattr(node, "enable_line_buffering", lambda: None)
    monkeypatch.setattr(node, "roslaunch_number", lambda: LAUNCH)
    monkeypatch.setattr(node, "end_with_roslaunch", found.append)
    monkeypatch.setattr(node, "NodeProbe", Probe)
    return found


def refuse():
    raise InvalidValueError(Message("the port is taken"))


@each_case("other", [False, True])
@each_case("needed, launches", [(True, [LAUNCH]), (False, [])])
def test_only_a_node_that_is_needed_ends_its_launch(ended, monkeypatch, other, needed, launches):
    monkeypatch.setattr(Probe, "other", other)
    ended.clear()
    with pytest.raises(SystemExit) as status:
        node.run_node("node", refuse, needed)
    assert status.value.code == 1
    assert ended == launches
