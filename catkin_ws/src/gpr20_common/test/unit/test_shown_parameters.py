"""Parameters as the parameter server can hold them."""

import enum
import xmlrpc.client

import pytest
from case_kit import each_case

pytest.importorskip("rospy")

from gpr20_common.high.shown_parameters import shown


class Kind(enum.Enum):
    LINEAR = "LIN"


@each_case(
    "value, expected",
    [
        (None, ""),
        (Kind.LINEAR, "LIN"),
        ((1, (2.5, None)), [1, [2.5, ""]]),
        ({"site": {"name": None}}, {"site": {"name": ""}}),
        (2**31 - 1, 2**31 - 1),
        (2**31, 2.0**31),
        (True, True),
        ("Bogotá", "Bogotá"),
        ("two\nlines\x00", '"two\\nlines\\u0000"'),
    ],
)
def test_every_value_can_be_sent(value, expected):
    assert shown(value) == expected
    (received,), _method = xmlrpc.client.loads(xmlrpc.client.dumps((shown(value),), "setParam"))
    assert received == expected
