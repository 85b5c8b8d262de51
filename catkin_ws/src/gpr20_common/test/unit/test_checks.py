"""Checks of values from outside."""

import math

from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.checks import instrument_address, ipv4_address, number_between


@each_case("value", [-1e-9, 10.1, math.nan, math.inf, -math.inf, 10**400, -(10**400)])
def test_a_value_outside_the_bounds_is_refused_with_name_value_bounds_and_unit(value):
    with raises_fault(faults.NOT_ALLOWED, "speed", 0, "10 m/s", error=InvalidValueError):
        number_between("speed", value, 0.0, 10.0, "m/s")
    assert [number_between("speed", one, 0.0, 10.0) for one in (0.0, 10.0)] == [0.0, 10.0]


@given(st.text("0123456789.-+٤ x", max_size=15) | st.text(max_size=9))
def test_a_text_is_an_address_or_refused(text):
    try:
        ipv4_address("address", text)
    except InvalidValueError as error:
        assert error.message.fault == faults.NOT_ALLOWED and text in str(error)
    else:
        assert [0 <= int(part) <= 255 for part in text.split(".")] == [True] * 4


@each_case(
    "address, allowed",
    [
        *(
            (one, True)
            for one in ("192.168.1.5", "TCPIP0::192.168.1.5::inst0::INSTR", "ASRL/dev/a::R")
        ),
        *((one, False) for one in ("", "192.168.1", "vna.local", "A::b c", "A::\n", "A::ñ")),
        ("A::" + "b" * 126, False),
    ],
)
def test_an_address_of_an_instrument_is_four_numbers_or_set_apart_from_them(address, allowed):
    if allowed:
        assert instrument_address("address", address) == address
    else:
        with raises_fault(faults.NOT_ALLOWED, address[:64], error=InvalidValueError):
            instrument_address("address", address)
