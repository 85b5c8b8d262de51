"""The interfaces for ROS 2 are those of ROS 1."""

from __future__ import annotations

import re
import sys

import ros2_interfaces
from case_kit import each_case
from rosbags.typesys import get_types_from_msg
from user_shell import ROOT, printed_by

ROS1 = ROOT / "catkin_ws/src/gpr20_msgs"
ROS2 = ROOT / "ros2/gpr20_msgs"
FOUND = ros2_interfaces.interfaces(ROS1)
ACTION_MESSAGES = [
    f"Axis{action}{part}" for action in ("", "Action") for part in ("Goal", "Result", "Feedback")
]
WRITTEN = sorted(path for path in ROS1.glob("*/*.*") if path.suffix[1:] == path.parent.name)


def parts_of(text: str) -> list[dict]:
    """Return constants and fields of each part of a definition, as another library reads them."""
    text = re.sub(r"^string operator(?=\s)", "string operator_name", text, flags=re.MULTILINE)
    parts = re.split(r"^---$", text, flags=re.MULTILINE)
    return [dict(get_types_from_msg(f"{part.strip()}\n", "gpr20_msgs/msg/Part")) for part in parts]


def test_every_interface_has_the_constants_and_fields_of_ros1():
    listed = {f"{one.parent.name}/{one.name}": one.read_text(encoding="utf-8") for one in WRITTEN}
    assert set(FOUND) == listed.keys() | {f"msg/{name}.msg" for name in ACTION_MESSAGES}
    for name, text in listed.items():
        assert parts_of(FOUND[name]) == parts_of(text), name
        assert not re.search(r"^(time|duration)\b", FOUND[name], re.MULTILINE)


@each_case("line", ["float64 Height", "float64 a__b", "float64 a_", "float64", "X=1"])
def test_a_name_that_ros2_does_not_allow_is_refused(line, tmp_path):
    (tmp_path / "msg").mkdir(exist_ok=True)
    (tmp_path / "msg/Wrong.msg").write_text(f"{line}\n")
    script = (sys.executable, ROS2 / "ros2_interfaces.py", tmp_path, tmp_path / "out")
    said = printed_by(*script, status=1)
    assert "Wrong.msg" in said and repr(line)[1:-1] in said
    assert not (tmp_path / "out").exists()
