"""A trace as a serialized ROS 1 message of the type gpr20_msgs/Trace, and back."""

from __future__ import annotations

import hashlib
import struct
from typing import Iterable

from gpr20_common.message import Message
from gpr20_common.mid.codec import shortened
from gpr20_survey import faults
from gpr20_survey.axes import ANTENNA_LINK
from gpr20_survey.errors import TraceRefusedError
from gpr20_survey.trace import trace_form as forms
from gpr20_survey.trace.trace import TRACE_FIELDS, AuxValue, Trace

DATATYPE = "gpr20_msgs/Trace"
_HEADER = "uint32 seq\ntime stamp\nstring frame_id\n"
_OTHER = "\n" + 80 * "=" + "\nMSG: "


def _lines(fields: Iterable[forms.TraceField]) -> str:
    return "".join(f"{one.form.ros} {one.name}  # {one.meaning}\n" for one in fields)


def _md5sum(fields: Iterable[forms.TraceField], first: str = "") -> str:
    """Return the checksum as ROS computes it: that of a message inside stands for its name."""
    types = ((_md5sum(one.form.parts) if one.form.parts else one.form.ros, one) for one in fields)
    lines = "\n".join([first, *(f"{kind} {one.name}" for kind, one in types)])
    return hashlib.md5(lines.strip().encode()).hexdigest()


MD5SUM = _md5sum(TRACE_FIELDS, f"{_md5sum((), _HEADER)} header")
DEFINITION = (
    f"std_msgs/Header header\n{_lines(TRACE_FIELDS)}"
    f"{_OTHER}std_msgs/Header\n{_HEADER}"
    f"{_OTHER}gpr20_msgs/AuxValue\n{_lines(forms.fields_of(AuxValue))}"
)
"""Definition of the message with its types, as it is recorded; the comments have no checksum."""


def encode(trace: Trace) -> bytes:
    stamp = forms.pack_time(trace.timestamp_us)
    return trace.packed(forms.UINT.pack(trace.index) + stamp + forms.pack_text(ANTENNA_LINK))


def decode(data: bytes, md5sum: str = MD5SUM) -> Trace:
    """Return the trace of a serialized message, checked.

    Args:
        data: The message.
        md5sum: Checksum of its type, where it is known.

    Raises:
        TraceRefusedError: It is of another version of the type, is not whole, or a value is not
            allowed.
    """
    if md5sum != MD5SUM:
        reason = Message(
            "a trace was recorded with version {found} of {datatype}; this software reads {own}",
            datatype=DATATYPE,
            found=shortened(md5sum),
            own=repr(MD5SUM),
        )
        raise TraceRefusedError(reason, fault=faults.OTHER_VERSION)
    reader = forms.Reader(data)
    try:
        reader.one(forms.UINT)  # every ROS publisher gives `seq` a number of its own
        # The rest of the header says again what the trace holds.
        reader.time_us(), reader.text()
        values = {one.attribute: one.form.unpack(reader) for one in TRACE_FIELDS}
        if reader.read(1):
            raise struct.error("it is longer than its fields")
    except (struct.error, UnicodeDecodeError) as error:
        reason = Message("a recorded trace is incomplete", details=error)
        raise TraceRefusedError(reason, fault=faults.DAMAGED) from error
    return Trace.of_values(values)
