import math

from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_user_interface.mid.parameter_form import hertz_from_megahertz, rotations_from_text


@given(st.integers(min_value=1, max_value=6_000_000_000))
def test_every_whole_hertz_can_be_written_in_megahertz(hertz):
    assert hertz_from_megahertz(f"{hertz // 10**6}.{hertz % 10**6:06d}") == hertz


def test_a_decimal_comma_is_read():
    assert hertz_from_megahertz("600,5") == 600_500_000.0
    assert rotations_from_text("1,8; 90") == (1.8, 90.0)


def test_numbers_beyond_any_arithmetic_do_not_escape():
    for text in ("1e999", "1e99999999999999999999", "1e999999999", "nan", "sNaN", "-inf", "1,5,0"):
        try:
            assert math.isinf(hertz_from_megahertz(text))
        except InvalidValueError as error:
            assert text in str(error)


def test_rotations_are_a_list_with_commas():
    assert rotations_from_text("0, 90,-45.5") == (0.0, 90.0, -45.5)
    for text in ("", "0,,90", "0;;90", "zero"):
        with raises_fault(NOT_ALLOWED, text):
            rotations_from_text(text)
