"""The environment of the tests, the same from a plain shell as from one that sourced ROS.

The built workspace is sourced and this interpreter comes first in PATH. Without ROS (Python 3.8
and 3.13) PYTHONPATH has the sources instead, for the processes that unit tests start.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, Mapping, NoReturn

import pytest

ROOT = Path(__file__).resolve().parents[2]
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
    """Prepare the environment, which the workers of pytest-xdist inherit, and the search path."""
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
    # The generated modules, behind the sources.
    for path in os.environ["PYTHONPATH"].split(os.pathsep):
        if path not in sys.path:
            sys.path.append(path)


def _interrupt(_number: int, _frame: Any) -> NoReturn:
    raise KeyboardInterrupt
