"""What tests of commands share, also those of other packages that add commands."""

import subprocess
import sys
import time

import pytest

from gpr20_analysis.commands import main
from gpr20_analysis.sentences import message_of


@pytest.fixture
def refusals(monkeypatch):
    """Codes of the faults with which commands of this process ended, the last one last."""
    codes = []

    def noted(error, command):
        message = message_of(error, command)
        codes.append(message.fault_code)
        return message

    monkeypatch.setattr(main, "message_of", noted)
    return codes


GPR20 = "import sys; from gpr20_analysis.commands.main import main; sys.exit(main())"
TIME_LIMIT_S = 60.0


def begun(arguments, is_at_work):
    """Return a command in a process group of its own, once it is at work."""
    process = subprocess.Popen(
        [sys.executable, "-c", GPR20, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    end_s = time.monotonic() + TIME_LIMIT_S
    while not is_at_work():
        assert process.poll() is None and time.monotonic() < end_s
        time.sleep(0.01)
    return process


def install(folder, entries, name, version="1.0", summary=""):
    """Write what pip writes beside an installed package.

    Args:
        folder: A folder of Python's path.
        entries: Its entry points, as in a file entry_points.txt.
        name: Name of the package.
        version: Its version.
        summary: Its summary.
    """
    information = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    information.mkdir(parents=True)
    about = f"Name: {name}\nVersion: {version}\nSummary: {summary}\n"
    (information / "METADATA").write_text(about)
    (information / "entry_points.txt").write_text(entries)
