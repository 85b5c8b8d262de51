"""A window that hangs ends, and says where it hung."""

import subprocess
import sys

from case_kit import each_case

PROGRAM = """
import threading, time
from gpr20_user_interface.low.process import HangGuard

def hang_here():
    {hang}

guard = HangGuard(1.0)
for _ in range(20):
    guard.beat()
    time.sleep(0.1)
{end}
hang_here()
"""


def run(hang, end=""):
    program = PROGRAM.format(hang=hang, end=end)
    return subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False
    )


@each_case("hang", ["threading.Event().wait(30)", "while True: pass"])
def test_a_window_that_hangs_ends_and_says_where(hang):
    ended = run(hang)
    assert ended.returncode == 1
    assert "hang_here" in ended.stderr


def test_a_window_that_is_closed_takes_its_time():
    assert run("time.sleep(2.0)", end="guard.end()").returncode == 0
