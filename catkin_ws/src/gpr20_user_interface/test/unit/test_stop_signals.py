import os
import signal
import subprocess
import sys
from pathlib import Path
from queue import SimpleQueue

import pytest

from gpr20_operator.robot.events import StopRequested
from gpr20_user_interface.low.process import SecondStopSignal, StopSignals, leave_now


@pytest.mark.parametrize(
    ("number", "name"), [(signal.SIGINT, "Ctrl-C"), (signal.SIGTERM, "SIGTERM")]
)
def test_first_signal_is_a_wish_and_the_second_leaves(number, name):
    events, before = SimpleQueue(), signal.getsignal(number)
    with StopSignals(lambda reason: events.put(StopRequested(reason))) as signals:
        assert not signals.received
        os.kill(os.getpid(), number)
        assert events.get(timeout=5.0) == StopRequested(name)
        assert signals.received
        with pytest.raises(SecondStopSignal):
            os.kill(os.getpid(), signal.SIGINT)
            events.get(timeout=5.0)
    assert signal.getsignal(number) is before


def test_further_signals_can_be_told_to_somebody_else():
    printed = []
    with StopSignals(printed.append, on_next=lambda: printed.append("again")):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGTERM)
    assert printed == ["Ctrl-C", "again"]


def test_leaving_at_once_waits_for_nobody_but_loses_no_words():
    program = (
        "import atexit, time\n"
        f"from {leave_now.__module__} import leave_now\n"
        "atexit.register(time.sleep, 60)\n"
        "print('last words')\n"
        "leave_now(130)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program],
        stdout=subprocess.PIPE,
        timeout=20,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert (ended.returncode, ended.stdout) == (130, b"last words\n")


def test_ctrl_c_while_the_client_is_loaded_ends_it_quietly(tmp_path):
    # In place of the first library that it loads; a shell may have begun this deaf to Ctrl-C.
    (tmp_path / "rospy.py").write_text(
        "import signal\nprint('loading', flush=True)\nwhile True: signal.pause()\n"
    )
    program = Path(__file__).resolve().parents[2] / "nodes" / "run_survey"
    process = subprocess.Popen(
        [sys.executable, str(program)],
        env={**os.environ, "PYTHONPATH": f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    try:
        assert process.stdout.readline() == "loading\n"
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=60.0)
    finally:
        process.kill()
    assert (process.returncode, error) == (-signal.SIGINT, "")
