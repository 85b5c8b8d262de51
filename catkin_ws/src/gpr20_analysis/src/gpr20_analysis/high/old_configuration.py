"""Completes the recorded `robot_configuration` of earlier versions."""

from __future__ import annotations

import struct
from typing import List

FORMER_MD5SUM = "3b9779b1131ed5c2e1d850c2f8562476"
_LENGTH = struct.Struct("<I")
SEQUENCE_BYTES, TIME_BYTES, BOOL_BYTES, FLOAT64_BYTES = 4, 8, 1, 8
# A description of today ends with three further texts: version, revision, host.
ADDED_TEXTS = bytes(3 * _LENGTH.size)
# And the configuration with one: fault_code.
ADDED_TEXT = bytes(_LENGTH.size)


class _Cursor:
    """Reads through a serialized message."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self.place = 0

    def skip(self, size: int) -> None:
        """Skip values of a fixed size.

        Raises:
            ValueError: The message is shorter.
        """
        self.place += size
        if self.place > len(self._data):
            raise ValueError("a recorded robot_configuration is cut off")

    def length(self) -> int:
        """Return the length of a text or list, and skip it."""
        before = self.place
        self.skip(_LENGTH.size)
        return int(_LENGTH.unpack_from(self._data, before)[0])

    def text(self) -> None:
        """Skip a text."""
        self.skip(self.length())


def completed_configuration(data: bytes) -> bytes:
    """Return a serialized RobotConfiguration of today, with empty texts for what is new.

    Args:
        data: The serialized message of the former definition.

    Raises:
        ValueError: It is cut off.
    """
    cursor = _Cursor(data)
    cursor.skip(SEQUENCE_BYTES + TIME_BYTES)
    cursor.text()  # frame_id
    cursor.skip(BOOL_BYTES)  # known
    cursor.text()  # message
    cursor.text()  # message_json
    cursor.skip(BOOL_BYTES)  # simulated
    parts: List[bytes] = []
    begin = 0
    for _node in range(cursor.length()):
        cursor.text()  # node
        cursor.text()  # hardware
        cursor.skip(BOOL_BYTES + FLOAT64_BYTES)  # simulated, time_scale
        cursor.text()  # configuration_json
        parts += [data[begin : cursor.place], ADDED_TEXTS]
        begin = cursor.place
    return b"".join((*parts, data[begin:], ADDED_TEXT))
