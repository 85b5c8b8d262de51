import random
from decimal import Decimal

from fault_kit import raises_fault

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_user_interface.mid.number_text import decimal_from_text, number_from_text, plain_text


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
