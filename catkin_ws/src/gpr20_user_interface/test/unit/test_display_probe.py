"""What runs in a process of its own: opening a display is tried, and a window that hangs ends."""

import os
import signal
import subprocess
import sys
import time

import psutil
from case_kit import each_case

from gpr20_user_interface.low.display_probe import display_problem


def raise_error():
    raise OSError("no such plugin")


def end_the_process():
    os.write(2, b"some library: loading\nsome library: could not connect to display :7\nmore\n")
    os.kill(os.getpid(), signal.SIGKILL)


@each_case(
    "open_display, limit_s, problem",
    [
        (lambda: print("a warning"), 30.0, None),
        (raise_error, 30.0, "OSError('no such plugin')"),
        # The line that names the display.
        (end_the_process, 30.0, "some library: could not connect to display :7"),
        (lambda: time.sleep(60), 0.2, "no answer within 0.2 s"),
    ],
)
def test_a_display_that_does_not_open_is_a_problem_with_its_reason(open_display, limit_s, problem):
    before = psutil.Process().children()
    assert display_problem(open_display, limit_s=limit_s) == problem
    assert psutil.Process().children() == before


PROGRAM = """
import threading, time
from gpr20_user_interface.low.process import HangGuard

def hang_here():
    {hang}

guard = HangGuard(1.0)
for _ in range(60):
    guard.beat()
    time.sleep(0.02)
{end}
hang_here()
"""


def run(hang, end=""):
    command = [sys.executable, "-c", PROGRAM.format(hang=hang, end=end)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100, check=False)


@each_case("hang", ["threading.Event().wait(60)", "while True: pass"])
def test_a_window_that_hangs_ends_and_says_where(hang):
    ended = run(hang)
    assert ended.returncode == 1
    assert "hang_here" in ended.stderr


def test_a_window_that_is_closed_takes_its_time():
    assert run("threading.Event().wait(1.5)", end="guard.end()").returncode == 0
