import os
import pty

import pytest

from gpr20_user_interface.terminal.displays import is_confirmed

pytestmark = pytest.mark.needs("terminals")


@pytest.fixture
def keyboard(monkeypatch):
    """Descriptor on which a test types; the question reads the other end."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "r") as stream:
        monkeypatch.setattr("sys.stdin", stream)
        yield ours
    os.close(ours)


def test_only_a_clear_yes_confirms(keyboard, capsys):
    for typed in ("y", "Yes", "s", "sí", "n", "", "x"):
        os.write(keyboard, f"{typed}\n".encode())
        confirmed = is_confirmed("Continue?", lambda: False)
        assert confirmed is (typed not in ("n", "", "x")), typed
        assert capsys.readouterr().out.startswith("Continue? ")


def test_a_stop_ends_the_question_with_no(keyboard):
    assert not is_confirmed("Continue?", lambda: True)


def test_an_input_that_ends_is_no(monkeypatch):
    with open(os.devnull) as stream:
        monkeypatch.setattr("sys.stdin", stream)
        assert not is_confirmed("Continue?", lambda: False)
