"""What tests of commands share, also those of other packages that add commands."""

import pytest

from gpr20_analysis.commands import main
from gpr20_analysis.commands.failure import message_of


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
