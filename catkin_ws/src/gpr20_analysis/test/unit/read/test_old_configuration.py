"""A recorded configuration of an earlier version that is cut off is refused."""

import struct

import pytest

pytest.importorskip("gpr20_analysis.high")

from gpr20_analysis.high.old_recordings import (
    ADDED_TEXT,
    ADDED_TEXTS,
    completed_configuration,
)


def text(words):
    return struct.pack("<I", len(words)) + words


NODE = text(b"x_axis") + text(b"DRV8825") + b"\1" + struct.pack("<d", 2.0) + text(b"{}")
BEGIN = bytes(12) + text(b"") + b"\1" + text(b"why") + text(b"{}") + b"\0"
SITE = text(b"{}")


@pytest.mark.parametrize("nodes", [0, 1, 3])
def test_each_node_gets_empty_texts_for_what_is_new(nodes):
    count = struct.pack("<I", nodes)
    former = BEGIN + count + NODE * nodes + SITE
    today = BEGIN + count + (NODE + ADDED_TEXTS) * nodes + SITE + ADDED_TEXT
    assert completed_configuration(former) == today


def test_a_message_that_is_cut_off_anywhere_is_refused():
    former = BEGIN + struct.pack("<I", 1) + NODE
    for size in range(len(BEGIN + NODE)):
        with pytest.raises(ValueError, match="cut off"):
            completed_configuration(former[:size])
