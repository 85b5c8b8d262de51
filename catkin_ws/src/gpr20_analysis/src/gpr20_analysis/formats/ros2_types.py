"""The message types of ROS 1 as ROS 2 has them, and messages in its encoding, CDR."""

from __future__ import annotations

from typing import Any, Dict, List, Tuple

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

# Of the releases that every version of rosbags knows, the last. Later ones have the same
# definitions of what the robot publishes; rosgraph_msgs/Log is in none of them.
from rosbags.typesys.stores.ros2_iron import FIELDDEFS as ROS2

Fields = List[Tuple[str, Any]]
Types = Dict[str, Tuple[Any, Fields]]
HEADER = "std_msgs/msg/Header"
EMPTY = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}
ONE_BYTE = {"byte": "uint8", "char": "uint8"}


class Ros2Type:
    """One recorded type and its counterpart.

    A type that ROS 2 has too gets the fields that ROS 2 has added, empty; every other type keeps
    its own. In both a Header has no number.

    Attributes:
        name: Such as "gpr20_msgs/msg/Trace".
        definition: Its text with those of all types it contains.
        digest: Hash of the type, as ROS 2 computes it.
    """

    def __init__(self, datatype: str, definition: str) -> None:
        """Find the counterpart.

        Args:
            datatype: Such as "gpr20_msgs/Trace".
            definition: Its text in ROS 1 with those of all types it contains.

        Raises:
            Exception: Of any kind, if the definition is damaged.
        """
        package, _, own = datatype.partition("/")
        self.name = f"{package}/msg/{own}"
        # An empty text is the definition of a type without fields.
        recorded: Types = get_types_from_msg(definition or "\n", self.name)
        self._types = _counterparts(recorded, self.name)
        self._same = all(
            self._types[name][1] == fields
            for name, (_, fields) in recorded.items()
            if name != HEADER
        )
        self._recorded = get_typestore(Stores.EMPTY)
        self._recorded.register(recorded)
        self._store = get_typestore(Stores.EMPTY)
        self._store.register(self._types)
        self.definition = self._store.generate_msgdef(self.name, ros_version=2)[0]
        self.digest = self._store.hash_rihs01(self.name)

    def message(self, data: bytes) -> bytes:
        """Return a serialized message of ROS 1 in CDR.

        Raises:
            Exception: Of any kind, for damaged bytes.
        """
        if self._same:
            return bytes(self._store.ros1_to_cdr(data, self.name))
        value = self._filled(self.name, self._recorded.deserialize_ros1(data, self.name))
        return bytes(self._store.serialize_cdr(value, self.name, little_endian=True))

    def _filled(self, name: str, value: Any) -> Any:
        """Return a value of a type with the fields of ROS 2; None stands for an empty one."""
        fields = self._types[name][1]
        return self._store.types[name](
            *(self._field(kind, getattr(value, field, None)) for field, kind in fields)
        )

    def _field(self, kind: Any, value: Any) -> Any:
        node, inside = kind
        if node == Nodetype.NAME:
            return self._filled(inside, value)
        if node == Nodetype.BASE:
            return EMPTY.get(inside[0], 0) if value is None else value
        (item_node, item), size = inside
        if item_node == Nodetype.NAME:
            return [self._filled(item, one) for one in ([None] * size if value is None else value)]
        if value is not None:
            return value
        if item[0] == "string":
            return [""] * size
        return np.zeros(size, dtype=ONE_BYTE.get(item[0], item[0]))


def _counterparts(recorded: Types, name: str) -> Types:
    """Return the definitions for ROS 2 of a recorded type and of all that it contains."""
    found: Types = {}
    left = [name]
    while left:
        one = left.pop()
        if one in found:
            continue
        own = recorded.get(one)
        known = ROS2.get(one)
        if own is None or (known is not None and _has_all(known[1], own[1], one)):
            found[one] = ROS2[one]
        else:
            found[one] = own
        left += [inside for _, kind in found[one][1] for inside in _names(kind)]
    return found


def _has_all(known: Fields, recorded: Fields, name: str) -> bool:
    """Return whether nothing is lost if the fields that ROS 2 has take the place of others."""
    dropped = ("seq",) if name == HEADER else ()
    return all(field in known for field in recorded if field[0] not in dropped)


def _names(kind: Any) -> List[str]:
    node, inside = kind
    if node == Nodetype.NAME:
        return [inside]
    return _names(inside[0]) if node in (Nodetype.ARRAY, Nodetype.SEQUENCE) else []
