"""Random recorded messages of ROS 1, of every type of the robot."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.stores.ros1_noetic import FIELDDEFS
from survey_kit import MESSAGES

from gpr20_survey.recording.recording import RecordedMessage

# Those of the robot, and what rosbags does not know.
OWN = get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage")
for path in sorted(MESSAGES.glob("*.msg")):
    OWN.update(get_types_from_msg(path.read_text(), f"gpr20_msgs/msg/{path.stem}"))
TYPES = get_typestore(Stores.ROS1_NOETIC)
TYPES.register(OWN)
FIELDS = {**FIELDDEFS, **OWN}
# Those of ROS that the robot records, and what is special: no field, lists of lists.
OTHERS = (
    *("actionlib_msgs/msg/GoalStatusArray", "diagnostic_msgs/msg/DiagnosticArray"),
    *("rosgraph_msgs/msg/Log", "sensor_msgs/msg/Image", "sensor_msgs/msg/JointState"),
    *("sensor_msgs/msg/Range", "sensor_msgs/msg/PointCloud2", "std_msgs/msg/Empty"),
    *("std_msgs/msg/String", "std_msgs/msg/Float64MultiArray"),
    *("visualization_msgs/msg/Marker", "visualization_msgs/msg/MarkerArray"),
)
TEXTS = st.text(st.characters(blacklist_categories=("Cs",), blacklist_characters="\0"), max_size=9)


def of_kind(kind):
    """Return the strategy for a field."""
    node, inside = kind
    if node == Nodetype.NAME:
        return of_type(inside)
    if node == Nodetype.BASE:
        return of_base(inside[0])
    (item_node, item), size = inside
    most = {"min_size": size, "max_size": size or 3}
    many = st.lists(of_kind(inside[0]), **most)
    if item_node == Nodetype.NAME or item[0] == "string":
        return many
    dtype = {"byte": "int8", "char": "uint8"}.get(item[0], item[0])
    return many.map(lambda found: np.array(found, dtype=dtype))


def of_base(name):
    if name == "string":
        return TEXTS
    if name == "bool":
        return st.booleans()
    if name.startswith("float"):
        return st.floats(width=int(name[5:]))
    if name == "byte":  # it has a sign in ROS 1 alone
        return st.integers(0, 127)
    limits = np.iinfo("uint8" if name == "char" else name)
    return st.integers(int(limits.min), int(limits.max))


def of_type(name):
    if name.startswith("builtin_interfaces/"):  # time and duration, as ROS 1 normalizes them
        make = TYPES.types[name]
        return st.builds(make, st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1))
    fields = FIELDS[name][1]
    if not fields or fields[0][0] == "structure_needs_at_least_one_member":
        return st.builds(TYPES.types[name])
    return st.builds(TYPES.types[name], *(of_kind(kind) for _field, kind in fields))


@st.composite
def recorded(draw, names=(*OWN, *OTHERS)):
    name = draw(st.sampled_from(names))
    definition, md5sum = TYPES.generate_msgdef(name)
    data = bytes(TYPES.serialize_ros1(draw(of_type(name)), name))
    datatype = name.replace("/msg/", "/")
    return RecordedMessage(
        f"/some/{name.split('/')[-1].lower()}",
        *(datatype, md5sum, definition, data, draw(st.integers(1, 2**61)), draw(st.booleans())),
    )
