import math
import random
from decimal import Decimal

from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_operator.words import (
    decimal_from_text,
    hertz_from_megahertz,
    number_from_text,
    plain_text,
    rotations_from_text,
)


def test_point_and_comma_are_the_same():
    for text in ("12.5", "12,5", " 12,50 ", "+12.5", "1.25e1", "1,25E+1"):
        assert number_from_text(text) == 12.5


def test_what_is_no_number_is_refused():
    for text in (
        *("", ",", ".", "1.2.3", "1,234.5", "1.234,5", "1_0", "٣", "nan", "inf", "0x1", "1 2"),
        *("--1", "six hundred", "600 MHz"),
    ):
        with raises_fault(NOT_ALLOWED, text, error=InvalidValueError):
            number_from_text(text)


def test_random_numbers_are_read_with_either_mark():
    draw = random.Random(3)
    for _ in range(500):
        text = f"{draw.uniform(-1e4, 1e4):.{draw.randint(0, 9)}f}"
        assert decimal_from_text(text.replace(".", ",")) == decimal_from_text(text) == Decimal(text)
        assert Decimal(plain_text(Decimal(text))) == Decimal(text)


@given(st.integers(min_value=1, max_value=6_000_000_000))
def test_every_whole_hertz_can_be_written_in_megahertz(hertz):
    assert hertz_from_megahertz(f"{hertz // 10**6}.{hertz % 10**6:06d}") == hertz


def test_a_decimal_comma_is_read():
    assert hertz_from_megahertz("600,5") == 600_500_000.0
    assert rotations_from_text("1,8; 90") == (1.8, 90.0)


def test_numbers_beyond_any_arithmetic_do_not_escape():
    for text in ("1e999", "1e99999999999999999999", "1e999999999"):
        try:
            assert math.isinf(hertz_from_megahertz(text))
        except InvalidValueError as error:
            assert text in str(error)
    for text in ("nan", "inf", "-inf", "1,5,0", "sNaN"):
        with raises_fault(NOT_ALLOWED, text):
            hertz_from_megahertz(text)


def test_rotations_are_a_list_with_commas():
    assert rotations_from_text("0, 90,-45.5") == (0.0, 90.0, -45.5)
    for text in ("", "0,,90", "0;;90", "zero"):
        with raises_fault(NOT_ALLOWED, text):
            rotations_from_text(text)
