"""The messages of errors."""

from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, message_of


def test_an_error_of_our_own_has_its_own_message():
    message = Message("the {axis} axis failed", axis="x")
    assert message_of(DeviceError(message)) == message


def test_the_message_of_a_program_error_is_short_enough_to_close_a_survey():
    text = str(message_of(RuntimeError("x" * 100_000)))
    assert text.startswith("internal error in the main control (RuntimeError: xxx")
    assert len(text) < 4096
