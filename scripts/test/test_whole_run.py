"""How one run of pytest does all tests: repeats alone, the end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import Counter

import pytest
from pytest_gpr20.real_time import RunLock
from pytest_gpr20.workspace import ROOT, SOURCES, with_ros, without_ros

pytest_plugins = ["pytester"]
LIMIT_S = 60.0
PLUGINS = ("real_time", "workspace")
LOADED = [word for one in PLUGINS for word in ("-p", f"pytest_gpr20.{one}")]


@pytest.fixture
def own(pytester, monkeypatch):
    """Yield a folder for tests that the plugins run on; they leave nothing behind."""
    monkeypatch.setenv("PYTHONPATH", f"{ROOT / 'tools'}:{os.environ.get('PYTHONPATH', '')}")
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    monkeypatch.setenv("TMPDIR", str(pytester.path))
    yield pytester
    assert not list(pytester.path.glob("gpr20_*"))


def wait_until(condition):
    deadline_s = time.monotonic() + LIMIT_S
    while not condition():
        assert time.monotonic() < deadline_s
        time.sleep(0.02)


def test_only_what_depends_on_real_time_is_repeated(own):
    own.makepyfile(
        "import pytest\n"
        "def test_pure(tries=[]): tries.append(1); assert len(tries) == 2\n"
        "@pytest.mark.real_time\n"
        "def test_timed(tries=[]): tries.append(1); assert len(tries) == 2\n"
        "@pytest.mark.real_time\n"
        "def test_never(): assert False\n"
    )
    ended = own.runpytest_subprocess(*LOADED, "-rR")
    assert ended.parseoutcomes() == {"passed": 1, "failed": 2, "rerun": 2}
    ended.stdout.fnmatch_lines(["RERUN *::test_timed", "RERUN *::test_never"])


def test_a_repeated_test_runs_alone(own):
    # While it is repeated no other test may be between its two lines.
    record = (
        "import os, pathlib, time\n"
        "def record(word):\n"
        "    with open(pathlib.Path(__file__).with_name('log'), 'a') as log:\n"
        "        log.write(word + os.linesep)\n"
    )
    own.makepyfile(record=record)
    for number in range(3):
        (own.path / f"test_{number}.py").write_text(
            "import pytest, time\nfrom record import record\n"
            "@pytest.mark.parametrize('number', range(20))\n"
            "def test_short(number): record('begin'); time.sleep(0.02); record('end')\n"
        )
    (own.path / "test_timed.py").write_text(
        "import pytest, time\nfrom record import record\n"
        "@pytest.mark.real_time\n"
        "def test_timed(tries=[]):\n"
        "    tries.append(1)\n"
        "    assert len(tries) == 2\n"
        "    record('alone'); time.sleep(0.3); record('no longer')\n"
    )
    ended = own.runpytest_subprocess(*LOADED, "-n3")
    assert ended.ret == 0
    lines = (own.path / "log").read_text().split("\n")
    alone = lines.index("alone")
    assert lines[alone + 1] == "no longer"
    before = Counter(lines[:alone])
    assert before["begin"] == before["end"]


def test_who_waits_to_run_alone_is_not_overtaken(tmp_path):
    one, other, alone = (RunLock(tmp_path) for _ in range(3))
    one.acquire(alone=False)
    other.acquire(alone=False)
    other.release()
    child = os.fork()
    if not child:
        alone.acquire(alone=True)
        (tmp_path / "alone").touch()
        os._exit(0)
    wait_until(lambda: gate_is_closed(tmp_path))
    assert not (tmp_path / "alone").exists()
    one.release()
    assert os.waitpid(child, 0)[1] == 0


def gate_is_closed(folder):
    """Return whether somebody waits to run alone."""
    trial = "import fcntl, sys; fcntl.flock(open(sys.argv[1], 'w'), fcntl.LOCK_SH | fcntl.LOCK_NB)"
    ended = subprocess.run([sys.executable, "-c", trial, folder / "gate"], stderr=subprocess.PIPE)
    return ended.returncode != 0


def test_a_test_that_hangs_or_ends_its_worker_has_failed_and_the_others_run(own):
    own.makepyfile(
        test_hangs="""
            import subprocess
            def test_bad(): subprocess.run(['sleep', '600'])
            def test_a(): pass
        """,
        test_ends="def test_bad():\n    import os; os._exit(3)",
        test_b="def test_b(): pass",
        test_c="def test_c(): pass",
    )
    limits = ["--timeout=3", "--max-worker-restart=0"]
    ended = own.runpytest_subprocess(*LOADED, "-n2", "--dist=loadfile", *limits)
    assert ended.ret == pytest.ExitCode.TESTS_FAILED
    said = ended.stdout.str()
    assert "crashed while running" in said and "Timeout (>3.0s) from pytest-timeout" in said
    assert ended.parseoutcomes()["passed"] == 3


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_nothing_keeps_running_when_it_is_ended(own, number):
    # In a session of its own, as what a launch starts; the shell's `&` makes it ignore Ctrl-C.
    own.makepyfile(
        "import subprocess\n"
        "def test_long():\n"
        "    line = 'echo $$ > pid.new; mv pid.new pid; sleep 600'\n"
        "    subprocess.run(['setsid', '--wait', 'bash', '-c', line])\n"
    )
    pytest_command = [sys.executable, "-m", "pytest", *LOADED, "-n2", str(own.path)]
    line = '"$@" & echo $! > pytest.new; mv pytest.new pytest; wait $!'
    shell = subprocess.Popen(["bash", "-c", line, "bash", *pytest_command], cwd=own.path)
    pid = own.path / "pid"
    wait_until(pid.exists)
    os.kill(int((own.path / "pytest").read_text()), number)
    assert shell.wait(LIMIT_S) == pytest.ExitCode.INTERRUPTED
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)


def test_the_environment_of_rostests_finds_generated_modules_from_any_shell(tmp_path):
    if not (ROOT / "catkin_ws/devel/setup.bash").exists():
        pytest.skip("the workspace is not built")
    program = "import gpr20_simulator.srv, gpr20_msgs.msg, gpr20_survey, sys; print(sys.prefix)"
    plain = {"PATH": "/usr/bin:/bin", "HOME": str(tmp_path)}
    odd = {"ROS_HOSTNAME": "elsewhere", "ROS_IPV6": "on", "ROSCONSOLE_CONFIG_FILE": "/missing"}
    odd.update({"ROS_PYTHON_LOG_CONFIG_FILE": "/missing", "GPR20_DATA": "/missing"})
    plain.update(odd)
    for shell in (plain, without_ros(plain), without_ros(os.environ)):
        environment = with_ros(shell)
        ended = subprocess.run(
            ["python", "-c", program],
            env=environment,
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
        assert ended.stdout.strip() == sys.prefix
        assert environment["ROS_IP"] == "127.0.0.1"
        assert not odd.keys() & environment.keys()


def test_unit_tests_find_generated_modules_from_any_shell(own, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "tools"))
    own.makepyfile("def test_one(): import gpr20_msgs.msg")
    assert own.runpytest_subprocess(*LOADED, "-n1").ret == 0


def test_every_package_is_found_without_a_workspace():
    setting = (ROOT / "pyproject.toml").read_text().split("pythonpath = [")[1].split("]")[0]
    listed = {line.strip().strip('",') for line in setting.splitlines() if line.strip()}
    others = {"tools", "tools/checks", "tools/kits", "tools/pages", "deploy/update"}
    others.add("ros2/gpr20_msgs")
    assert listed == {*others, *(os.path.relpath(one, ROOT) for one in SOURCES)}
    assert set(SOURCES) == {str(one) for one in ROOT.glob("catkin_ws/src/*/src")}


def test_no_two_modules_of_the_tests_have_the_same_name():
    # All of them are imported into one process.
    folders = [
        *ROOT.glob("catkin_ws/src/*/test/unit"),
        ROOT / "scripts/test",
        *(ROOT / "tools" / one for one in ("checks", "kits", "pages")),
    ]
    names = Counter(path.name for folder in folders for path in folder.rglob("*.py"))
    assert {name for name, number in names.items() if number > 1} - {"conftest.py"} == set()


def test_an_unknown_part_is_refused_before_anything_is_installed():
    ended = subprocess.run(
        [str(ROOT / "scripts/test.sh"), "units"], stderr=subprocess.PIPE, text=True, timeout=LIMIT_S
    )
    assert ended.returncode == 2
    assert "'units' is neither a path nor one of lint, unit, ros, commands" in ended.stderr
