"""The plugin of pytest for this project; the conftest.py of the checkout loads it.

- The environment of the tests is the same from a plain shell as from one that sourced ROS. The
  built workspace is sourced and this interpreter comes first in PATH. Without ROS (Python 3.8 and
  3.13) PYTHONPATH has the sources instead, for the processes that unit tests start.
- With a test or with the whole run every process ends that the tests have started. It is known by
  a variable of its environment: what a launch starts is in sessions of its own, and a child of
  init when its parent was killed.
- Each file `*.test` is one test, run by `rostest` in its own process.
- `@pytest.mark.needs("mounts")` skips a test that needs what this machine does not allow: a
  container, a chroot or an ordinary user may not mount, or make a network. Each ability is tried
  once, when the tests are collected.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, NoReturn, Optional
from xml.etree import ElementTree

import psutil
import pytest

ROOT = Path(__file__).resolve().parents[1]
WORKSPACE = ROOT / "catkin_ws"
SOURCES = [str(path) for path in sorted((WORKSPACE / "src").glob("gpr20_*/src"))]
# Variables of a shell that begin so would make the nodes of a test listen elsewhere, write
# elsewhere or look for another robot.
UNSET = ("ROS_", "ROSCONSOLE_", "GPR20_DATA", "GPR20_ROBOT", "GPR20_SERVER")


def without_ros(environment: Mapping[str, str]) -> Dict[str, str]:
    """Return an environment whose PYTHONPATH has the sources and nothing else."""
    return {**environment, "PYTHONPATH": os.pathsep.join(SOURCES)}


def with_ros(environment: Mapping[str, str]) -> Dict[str, str]:
    """Return an environment in which the built workspace was sourced.

    Raises:
        pytest.UsageError: The workspace was not built.
    """
    setup = WORKSPACE / "devel/setup.bash"
    if not setup.exists():
        raise pytest.UsageError(f"{setup} is missing; run scripts/setup.sh --dev first")
    clean = {name: value for name, value in environment.items() if not name.startswith(UNSET)}
    # The sources would hide the generated modules (gpr20_simulator.srv).
    paths = clean.get("PYTHONPATH", "").split(os.pathsep)
    clean["PYTHONPATH"] = os.pathsep.join(one for one in paths if one and one not in SOURCES)
    clean["ROS_IP"] = "127.0.0.1"
    sourced = subprocess.check_output(
        ["bash", "-c", f"source '{setup}' && env -0"], env=clean, text=True
    )
    result = dict(line.split("=", 1) for line in sourced.split("\0") if line)
    result["PATH"] = os.pathsep.join([str(Path(sys.prefix) / "bin"), result["PATH"]])
    return result


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Prepare the environment, which the workers of pytest-xdist inherit, and the search path.

    What this process will start is marked.
    """
    # A worker's mark begins with that of the whole run.
    run = getattr(config, "workerinput", {}).get("gpr20_mark", "")
    if not hasattr(config, "workerinput"):
        # A shell starts what it runs in the background (`&`, nohup) with Ctrl-C ignored. The tests
        # send Ctrl-C to processes of their own, which would inherit that.
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, _interrupt)
        has_ros = importlib.util.find_spec("rospy") is not None
        prepared = with_ros(os.environ) if has_ros else without_ros(os.environ)
        # The robot as it is built, whatever the configuration of this computer's user is. The state
        # says which data folders were used before: names below /tmp return, after a restart.
        for name in ("config", "state"):
            folder = config.rootpath / ".pytest_cache" / name
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            prepared[f"GPR20_{name.upper()}"] = str(folder)
        os.environ.clear()
        os.environ.update(prepared)
    os.environ[VARIABLE] = f"{run}{os.getpid()}."
    # The generated modules, behind the sources.
    for path in os.environ["PYTHONPATH"].split(os.pathsep):
        if path not in sys.path:
            sys.path.append(path)


def _interrupt(_number: int, _frame: Any) -> NoReturn:
    raise KeyboardInterrupt


VARIABLE = "STARTED_BY_TESTS"
# Longer than roslaunch takes to end its nodes.
END_LIMIT_S = 20.0
POLL_S = 0.05
NAMES: pytest.StashKey[List[str]] = pytest.StashKey()


def end_processes(mark: str) -> List[str]:
    """End other processes, gently first; return their names.

    Args:
        mark: How the variable of their environment begins.
    """
    found: Dict[psutil.Process, str] = {}
    for process in psutil.process_iter():
        # It has ended meanwhile, or it is somebody else's.
        with contextlib.suppress(psutil.Error):
            marked = process.environ().get(VARIABLE, "").startswith(mark)
            if marked and process.pid != os.getpid():
                found[process] = " ".join(process.cmdline())
                process.terminate()
    deadline_s = time.monotonic() + END_LIMIT_S
    while any(map(_runs, found)):
        for process in found if time.monotonic() > deadline_s else ():
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()
        time.sleep(POLL_S)
    return list(found.values())


def _runs(process: psutil.Process) -> bool:
    """Return whether a process runs: the orphans of a container may stay zombies."""
    try:
        return process.status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Give a worker the mark of the run."""
    node.workerinput["gpr20_mark"] = os.environ[VARIABLE]


def pytest_exception_interact(call: Any) -> None:
    """End what a test has started that came to its time limit."""
    if "from pytest-timeout" in str(call.excinfo.value):
        end_processes(os.environ[VARIABLE])


def pytest_keyboard_interrupt() -> None:
    """End the workers too: pytest-xdist would kill them and nobody else."""
    end_processes(os.environ[VARIABLE])


def pytest_sessionfinish(session: pytest.Session) -> None:
    """End what the tests left running."""
    if not hasattr(session.config, "workerinput"):
        names = end_processes(os.environ[VARIABLE])
        # Python's own, which ends after the process whose resources it watches.
        left = [one for one in names if "resource_tracker" not in one]
        session.config.stash[NAMES] = left


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say what they left running."""
    for name in config.stash.get(NAMES, []):
        terminalreporter.write_line(f"LEFT RUNNING by a test, ended now: {name}")


# Beside the time limits of the tests in it: what a launch takes to begin and to end.
LAUNCH_LIMIT_S = 240.0
LINES_SHOWN = 120
TESTS = re.compile(r"^ \* TESTS: (\d+)", re.MULTILINE)
FAILED = re.compile(r"^\[(\S+)\]\[(?:FAILURE|ERROR)\]", re.MULTILINE)


class RostestItem(pytest.Item):
    """One rostest, with a master, logs and results of its own."""

    def runtest(self) -> None:
        """Run it; if a test fails or none runs, show which, and the end of what was printed."""
        pytest.importorskip("rospy", reason="this Python has no ROS")
        folder = Path(tempfile.mkdtemp(prefix="gpr20_rostest_"))
        own = {"ROS_HOME": folder, "ROS_LOG_DIR": folder / "log"}
        own["ROS_TEST_RESULTS_DIR"] = folder / "results"
        environment = {**os.environ, **{name: str(path) for name, path in own.items()}}
        # Unit tests in this process draw off screen; a rostest chooses its screen itself.
        environment.pop("QT_QPA_PLATFORM", None)
        ended = subprocess.run(
            ["rostest", str(self.path)],
            cwd=self.path.parent,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
        failed = ", ".join(sorted(set(FAILED.findall(ended.stdout))))
        counted = TESTS.findall(ended.stdout)
        found = "" if counted and int(counted[-1]) else "no test ran"
        if ended.returncode != 0 or failed:
            found = f"failed: {failed or f'rostest ended with status {ended.returncode}'}"
        if found:
            end = "\n".join(ended.stdout.splitlines()[-LINES_SHOWN:])
            pytest.fail(f"{found}; logs are in {folder}\n{end}", pytrace=False)
        shutil.rmtree(folder)

    def reportinfo(self) -> Any:
        """Name it by its file; a skip needs a line."""
        return self.path, 0, self.path.name


class RostestFile(pytest.File):
    """A file `*.test`."""

    def collect(self) -> Iterator[pytest.Item]:
        """Yield its only item."""
        item = RostestItem.from_parent(self, name="rostest")
        tests = ElementTree.parse(self.path).getroot().iter("test")
        limit_s = LAUNCH_LIMIT_S + sum(float(one.get("time-limit", 60)) for one in tests)
        item.add_marker(pytest.mark.timeout(limit_s))
        yield item


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> Optional[RostestFile]:
    """Collect a rostest."""
    if file_path.suffix == ".test":
        return RostestFile.from_parent(parent, path=file_path)
    return None


def pytest_ignore_collect(collection_path: Path) -> Optional[bool]:
    """Leave the Python files beside rostests to rostest."""
    inside = collection_path.parent.name == "ros" and collection_path.suffix == ".py"
    return True if inside else None


# A filter that lets no byte pass, attached as <asm-generic/socket.h> and <linux/filter.h> say.
ATTACH_FILTER = """
import ctypes, socket, struct
program = ctypes.create_string_buffer(struct.pack("=HBBI", 6, 0, 0, 0))
filters = struct.pack("@HP", 1, ctypes.addressof(program))
socket.socket().setsockopt(socket.SOL_SOCKET, 26, filters)
"""
IN_NETWORK = "ip netns add $TRY && {}; status=$?; ip netns del $TRY; exit $status"
# What a marker may name, and the shell's commands that try it.
ABILITIES = {
    "network namespaces": IN_NETWORK.format("ip -n $TRY link add end0 type veth peer name end1"),
    "firewall": IN_NETWORK.format("ip netns exec $TRY nft add table inet gpr20_try"),
    "socket filters": f"{sys.executable} -c '{ATTACH_FILTER}'",
    "mounts": "cd $(mktemp -d) && mount -t tmpfs tmpfs . && umount -l . && rmdir $PWD",
    "packages": 'dpkg-scanpackages --version && [ "$(id -u)" = 0 ]',
}


@functools.lru_cache(maxsize=None)
def reason_against(ability: str) -> str:
    """Return why this machine lacks an ability; empty if it has it.

    Args:
        ability: A name in `ABILITIES`.
    """
    ended = subprocess.run(
        ["/bin/sh", "-c", ABILITIES[ability]],
        env={**os.environ, "TRY": f"gpr20-try-{os.getpid()}"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        timeout=20,
    )
    return f"no {ability} here: {' '.join(ended.stderr.split())}" if ended.returncode else ""


def pytest_collection_modifyitems(items: List[pytest.Item]) -> None:
    """Skip the tests that need something that is not allowed."""
    for item in items:
        for marker in item.iter_markers("needs"):
            for reason in filter(None, map(reason_against, marker.args)):
                item.add_marker(pytest.mark.skip(reason=reason))
