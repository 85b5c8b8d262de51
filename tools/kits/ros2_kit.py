"""Comparing a recording of ROS 1 with its export to ROS 2, by readers that wrote neither."""

from __future__ import annotations

import struct
from itertools import zip_longest
from pathlib import Path
from typing import Any, Iterator, List, Tuple

import mcap_ros1.decoder
import mcap_ros2.decoder
from mcap.reader import make_reader

Decoded = Tuple[str, str, int, Any]


def decoded(path: Path) -> Iterator[Decoded]:
    """Yield topic, type, time and value of each message of an MCAP file, in its order."""
    factories = [mcap_ros1.decoder.DecoderFactory(), mcap_ros2.decoder.DecoderFactory()]
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=factories)
        messages = reader.iter_decoded_messages(log_time_order=False)
        for schema, channel, message, value in messages:
            assert schema is not None and message.publish_time == message.log_time
            yield channel.topic, schema.name.replace("/msg/", "/"), message.log_time, value


def exported(bag: Path) -> Iterator[Decoded]:
    """Yield the messages of a bag of ROS 2."""
    (path,) = bag.glob("*.mcap")
    return decoded(path)


def differences(recording: Path, bag: Path) -> List[str]:
    """Return what differs between an MCAP file of ROS 1 and a bag of ROS 2, in order of time."""
    found: List[str] = []
    both = (
        sorted(one, key=lambda it: (it[2], it[0])) for one in (decoded(recording), exported(bag))
    )
    for number, (one, two) in enumerate(zip_longest(*both)):
        if one is None or two is None:
            return [*found, f"only one has message {number}"]
        if one[:3] != two[:3] or not same(one[3], two[3]):
            found.append(f"message {number}: {one} {two}")
    return found


def same(one: Any, two: Any) -> bool:
    """Return whether a value of ROS 1 is that of ROS 2, bit for bit; a Header has no `seq`."""
    if hasattr(one, "nsecs"):
        return bool((one.secs, one.nsecs) == (two.sec, two.nanosec))
    if hasattr(one, "__slots__"):
        kind = getattr(one, "_type", "")
        names = [name for name in one.__slots__ if (kind, name) != ("std_msgs/Header", "seq")]
        return all(same(getattr(one, name), getattr(two, name)) for name in names)
    if isinstance(one, float):
        return struct.pack("<d", one) == struct.pack("<d", two)
    if isinstance(one, (list, tuple, bytes)):
        return len(one) == len(two) and all(map(same, one, two))
    return bool(one == two)
