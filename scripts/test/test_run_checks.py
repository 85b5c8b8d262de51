"""How the checks are run: side by side, each failure tried once more, and told."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from run_checks import Catalogue, Check, Runner, UnknownPartError

SCRIPT = Path(__file__).resolve().parents[1] / "run_checks.py"


@pytest.fixture
def shown():
    return []


def shell(name, line, **environment):
    return Check(name, ["bash", "-c", line], environment)


def test_what_passes_is_run_once_and_its_tests_are_told(shown):
    checks = [
        shell("one", "echo '12 passed, 1 skipped in 3.4s'"),
        shell("two", "echo ' * TESTS: 5'"),
    ]
    assert Runner(shown.append).run(checks, at_once=2) == []
    assert {line.split("passed")[1].strip() for line in shown[:2]} == {"12", "5"}
    assert "2 passed, 0 of them at the second try, 0 failed" in shown[-1]


def test_what_fails_once_is_tried_again_and_both_outcomes_are_shown(shown, tmp_path):
    line = f"echo said this; [ -e {tmp_path}/seen ] || {{ touch {tmp_path}/seen; exit 1; }}"
    assert Runner(shown.append).run([shell("flaky", line)], at_once=1) == []
    printed = "\n".join(shown)
    assert "FAILED" in shown[0] and "the first try:\nsaid this" in printed
    assert "1 passed, 1 of them at the second try, 0 failed" in shown[-1]


def test_what_fails_twice_has_failed(shown):
    checks = [shell("good", "true"), shell("bad", "echo because; exit 3")]
    (lasting,) = Runner(shown.append).run(checks, at_once=2)
    assert lasting.check.name == "bad" and lasting.printed == "because\n"
    assert "1 passed, 0 of them at the second try, 1 failed" in shown[-1]


def test_the_second_try_of_pytest_runs_what_failed_alone(shown):
    check = shell("pytest", "echo options: $PYTEST_ADDOPTS; exit 1", PYTEST_ADDOPTS="-o a=b")
    (lasting,) = Runner(shown.append).run([check], at_once=1)
    assert lasting.printed == "options: -o a=b --last-failed\n"


def test_no_more_run_at_once_than_allowed(shown, tmp_path):
    line = f"mkdir {tmp_path}/alone || exit 1; sleep 0.2; rmdir {tmp_path}/alone"
    checks = [shell(str(number), line) for number in range(3)]
    assert Runner(shown.append).run(checks, at_once=1) == []
    assert "0 of them at the second try" in shown[-1]


def test_every_test_file_is_part_of_a_check(tmp_path):
    checks = Catalogue(tmp_path).checks([])
    root = SCRIPT.parent.parent
    commands = [" ".join(one.command) for one in checks]
    for folder in root.glob("catkin_ws/src/*/test/unit"):
        assert any(line.endswith(str(folder)) for line in commands)
    for file in [*root.glob("catkin_ws/src/*/test/ros/*.test"), *root.glob("scripts/test/test_*")]:
        assert any(line.endswith(file.name) for line in commands)
    names = [one.name for one in checks]
    assert "scripts/lint.sh" in commands and len(set(names)) == len(names)


def test_parts_are_chosen_by_name_and_an_unknown_one_is_refused(tmp_path):
    assert [one.name for one in Catalogue(tmp_path).checks(["lint"])] == ["lint"]
    with pytest.raises(UnknownPartError, match="'units'; allowed are lint, commands, unit38, unit"):
        Catalogue(tmp_path).checks(["units"])


def test_nothing_goes_on_when_it_is_ended(tmp_path):
    # A process in a session of its own, as a launch that a test has begun.
    line = f"setsid --wait bash -c 'echo $$ > {tmp_path}/pid; sleep 600'"
    source = (
        "import run_checks as r, signal, sys\n"
        "signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))\n"
        f"r.Runner(print).run([r.Check('long', ['bash', '-c', {line!r}])], 1)\n"
    )
    runner = subprocess.Popen([sys.executable, "-c", source], cwd=SCRIPT.parent)
    pid = tmp_path / "pid"
    deadline_s = time.monotonic() + 60.0
    while not (pid.exists() and pid.read_text()):
        assert runner.poll() is None and time.monotonic() < deadline_s
        time.sleep(0.02)
    runner.send_signal(signal.SIGTERM)
    assert runner.wait(60.0) == 1
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)


def test_checks_hear_ctrl_c_though_a_script_began_them_in_the_background():
    source = (
        "import run_checks as r\n"
        "r.pass_on_ctrl_c()\n"
        "r.Runner(print).run([r.Check('deaf', ['bash', '-c', 'kill -INT $$; echo deaf'])], 1)\n"
    )
    line = f"'{sys.executable}' -c \"$0\" & wait $!"
    ended = subprocess.run(
        ["bash", "-c", line, source],
        cwd=SCRIPT.parent,
        capture_output=True,
        text=True,
        timeout=60.0,
    )
    assert ended.returncode == 0, ended.stderr
    assert "1 failed" in ended.stdout, ended.stdout
