"""Run the checks of the project side by side, one more than there are processors.

The robot's time limits are real seconds, which a machine that stalls breaks without anybody's
fault: checks that failed are tried once more when all others have ended, one after the other, and
both outcomes are shown.

    python scripts/run_checks.py [lint] [unit] [unit38] [ros] [commands]

Everything that the checks need must be installed, and the workspace sourced: `scripts/test.sh`
does both.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable, Dict, List, Sequence, Set

import psutil

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ROOT / "catkin_ws/src"
PYTHON_38 = ROOT / ".venv38/bin/python"
# Far more than any check takes: it ends what hangs.
LIMIT_S = 900.0
# Longer than roslaunch takes to end its nodes.
END_LIMIT_S = 20.0
# As pytest and rostest say how many tests there were.
COUNTED = re.compile(r"(\d+ passed.*) in |\* TESTS: (\d+)")


class UnknownPartError(ValueError):
    """A part of the checks has a name that is not known."""


@dataclass(frozen=True)
class Check:
    """A command that ends with status 0 if all is well.

    Attributes:
        name: What it is called where results are shown.
        command: The program and its arguments.
        environment: What it finds in its environment besides that of this process.
    """

    name: str
    command: Sequence[str]
    environment: Dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """How a check ended.

    Attributes:
        check: Which one.
        passed: Whether its status was 0.
        seconds: How long it took.
        printed: What it printed.
    """

    check: Check
    passed: bool
    seconds: float
    printed: str

    def __str__(self) -> str:
        ended = f"passed  {self._counted()}" if self.passed else "FAILED"
        return f"{self.check.name:48}{self.seconds:6.0f} s  {ended}".rstrip()

    def _counted(self) -> str:
        found = COUNTED.findall(self.printed)
        by_pytest, by_rostest = found[-1] if found else ("", "")
        return by_pytest or (f"{by_rostest} passed" if by_rostest else "")


def end_with_descendants(pid: int) -> None:
    """End a process and all that came from it, in whatever session: a launch ends its own nodes.

    Args:
        pid: Of the process; that it has ended is no error.
    """
    try:
        parent = psutil.Process(pid)
        family = [parent, *parent.children(recursive=True)]
    except psutil.NoSuchProcess:
        return
    for one in family:
        # psutil knows a process from another one that got its number later.
        with contextlib.suppress(psutil.NoSuchProcess):
            one.terminate()
    _gone, alive = psutil.wait_procs(family, END_LIMIT_S)
    for one in alive:
        with contextlib.suppress(psutil.NoSuchProcess):
            one.kill()


class Runner:
    """Runs checks, and ends those that run when it is told to."""

    def __init__(self, show: Callable[[str], None]) -> None:
        self._show = show
        self._running: Set[subprocess.Popen] = set()
        self._lock = threading.Lock()
        self._closed = False

    def run(self, checks: Sequence[Check], at_once: int) -> List[Outcome]:
        """Run checks, so many at a time; return those that failed twice.

        Args:
            checks: What to run, in the order in which they begin.
            at_once: How many run at the same time.
        """
        failed = [one for one in self._outcomes(checks, at_once) if not one.passed]
        lasting = []
        for first in failed:
            self._show(f"\n--- {first.check.name}, the first try:\n{first.printed}")
            (second,) = self._outcomes([first.check], at_once=1, again=True)
            if not second.passed:
                self._show(f"--- {second.check.name}, the second try:\n{second.printed}")
                lasting.append(second)
        self._show(
            f"\n{len(checks) - len(lasting)} passed, {len(failed) - len(lasting)} of them at the "
            f"second try, {len(lasting)} failed"
        )
        return lasting

    def close(self) -> None:
        """End all that runs; nothing more begins."""
        with self._lock:
            self._closed = True
            for process in self._running:
                end_with_descendants(process.pid)

    def _outcomes(
        self, checks: Sequence[Check], at_once: int, again: bool = False
    ) -> List[Outcome]:
        outcomes = []
        with ThreadPoolExecutor(at_once) as pool:
            futures = [pool.submit(self._outcome, one, again) for one in checks]
            try:
                for future in as_completed(futures):
                    outcomes.append(future.result())
                    self._show(f"{outcomes[-1]}{', at the second try' if again else ''}")
            except BaseException:
                # Leaving the pool waits for what runs.
                self.close()
                raise
        return outcomes

    def _outcome(self, check: Check, again: bool) -> Outcome:
        begun_s = time.monotonic()
        with tempfile.TemporaryFile() as log:
            status = self._status(check, again, log.fileno())
            log.seek(0)
            printed = log.read().decode(errors="replace")
        return Outcome(check, status == 0, time.monotonic() - begun_s, printed)

    def _status(self, check: Check, again: bool, log: int) -> int:
        environment = {**os.environ, **check.environment}
        if again and "PYTEST_ADDOPTS" in environment:
            environment["PYTEST_ADDOPTS"] += " --last-failed"
        with self._lock:
            if self._closed:
                return -1
            process = subprocess.Popen(
                check.command,
                cwd=ROOT,
                env=environment,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            self._running.add(process)
        try:
            return process.wait(LIMIT_S)
        except subprocess.TimeoutExpired:
            os.write(log, f"\nstill running after {LIMIT_S:g} s, and ended\n".encode())
            end_with_descendants(process.pid)
            return process.wait()
        finally:
            with self._lock:
                self._running.discard(process)


class Catalogue:
    """The checks of each part."""

    def __init__(self, scratch: Path) -> None:
        """Name them.

        Args:
            scratch: Where the checks may leave things for their second try.
        """
        self._scratch = scratch
        # What takes longest begins first.
        self._parts: Dict[str, Callable[[], List[Check]]] = {
            "lint": lambda: [Check("lint", ["scripts/lint.sh"])],
            "commands": self._commands,
            "unit38": self._unit_38,
            "unit": self._unit,
            "ros": self._ros,
        }

    def checks(self, parts: Sequence[str]) -> List[Check]:
        """Return the checks of these parts; of all parts if none is named.

        Raises:
            UnknownPartError: A part is not known.
        """
        for part in parts:
            if part not in self._parts:
                raise UnknownPartError(
                    f"unknown part '{part}'; allowed are {', '.join(self._parts)}"
                )
        chosen = [make for part, make in self._parts.items() if part in parts or not parts]
        return [check for make in chosen for check in make()]

    def _pytest(self, name: str, python: str, path: Path, **environment: str) -> Check:
        cache = self._scratch / name.replace("/", "_").replace(" ", "_")
        return Check(
            name,
            [python, "-m", "pytest", "-q", str(path)],
            {"PYTEST_ADDOPTS": f"-o cache_dir={cache}", **environment},
        )

    def _commands(self) -> List[Check]:
        files = sorted((ROOT / "scripts/test").glob("test_*.py"))
        return [self._pytest(f"commands: {one.stem}", sys.executable, one) for one in files]

    def _unit(self) -> List[Check]:
        inherited = os.environ.get("PYTHONPATH", "")
        return self._unit_tests("unit", sys.executable, inherited)

    def _unit_38(self) -> List[Check]:
        # ROS's own packages belong to the other interpreter.
        return (
            self._unit_tests("unit, Python 3.8", str(PYTHON_38), "") if PYTHON_38.exists() else []
        )

    def _unit_tests(self, label: str, python: str, inherited: str) -> List[Check]:
        path = ":".join([*map(str, sorted(PACKAGES.glob("*/src"))), inherited])
        return [
            self._pytest(f"{label}: {folder.parts[-3]}", python, folder, PYTHONPATH=path)
            for folder in sorted(PACKAGES.glob("*/test/unit"))
        ]

    def _ros(self) -> List[Check]:
        environment = {"ROS_IP": "127.0.0.1", "ROS_TEST_RESULTS_DIR": str(self._scratch)}
        return [
            Check(
                f"ros: {file.parts[-4]}/{file.name}",
                ["rostest", file.parts[-4], file.name],
                environment,
            )
            for file in sorted(PACKAGES.glob("*/test/ros/*.test"))
        ]


def show(text: str) -> None:
    """Print at once: whoever waits wants to see how far it is."""
    print(text, flush=True)


def pass_on_ctrl_c() -> None:
    """Let the checks hear Ctrl-C: what a script begins with `&` or nohup is born deaf to it.

    Checks press Ctrl-C in what they started, which would inherit the deafness.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def main(parts: Sequence[str]) -> int:
    """Run the checks of these parts; return the exit status."""
    with tempfile.TemporaryDirectory(prefix="gpr20_checks_") as scratch:
        try:
            checks = Catalogue(Path(scratch)).checks(parts)
        except UnknownPartError as error:
            print(f"run_checks: {error}", file=sys.stderr)
            return 2
        signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))
        pass_on_ctrl_c()
        # Many of them wait for the robot more than they compute.
        at_once = (os.cpu_count() or 1) + 1
        return 1 if Runner(show).run(checks, at_once) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
