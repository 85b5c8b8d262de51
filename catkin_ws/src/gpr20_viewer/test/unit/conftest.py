"""What the tests of several files share."""

import re
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[2]
# The example surveys of gpr20_analysis's tests.
sys.path.append(str(PACKAGE.parent / "gpr20_analysis/test/unit"))

from command_kit import install, refusals  # noqa: E402, F401


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Make gpr20 find the viewer as where its pyproject.toml was installed by pip."""
    text = (PACKAGE / "pyproject.toml").read_text()
    (entry,) = re.findall(r'^view = "(.+)"$', text, re.MULTILINE)
    (summary,) = re.findall(r'^description = "(.+)"$', text, re.MULTILINE)
    entries = f"[gpr20.commands]\nview = {entry}\n"
    install(tmp_path / "site", entries, "gpr20_viewer", summary=summary)
    monkeypatch.syspath_prepend(tmp_path / "site")
    return entries
