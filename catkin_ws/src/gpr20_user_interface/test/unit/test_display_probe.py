"""Opening a display is tried in a process of its own, whatever the library does there."""

import os
import signal
import time

from gpr20_user_interface.low.display_probe import display_problem


def test_a_display_that_opens_is_no_problem():
    assert display_problem(lambda: print("a warning")) is None


def test_a_library_that_ends_its_process_gives_the_line_that_names_the_display():
    def open_display():
        os.write(2, b"some library: loading\nsome library: could not connect to display :7\nmore\n")
        os.kill(os.getpid(), signal.SIGKILL)

    assert display_problem(open_display) == "some library: could not connect to display :7"


def test_an_exception_is_a_problem_with_its_reason():
    def open_display():
        raise OSError("no such plugin")

    assert display_problem(open_display) == "OSError('no such plugin')"


def test_a_display_that_hangs_is_given_up():
    begin_s = time.monotonic()
    problem = display_problem(lambda: time.sleep(60), limit_s=0.2)
    assert problem == "no answer within 0.2 s"
    assert time.monotonic() - begin_s < 10.0


def test_no_child_is_left():
    for attempt in (lambda: None, lambda: os._exit(3)):
        display_problem(attempt)
    try:
        left = os.waitpid(-1, os.WNOHANG)
    except ChildProcessError:
        left = (0, 0)
    assert left == (0, 0)
