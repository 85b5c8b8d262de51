"""What the tests of several files share."""

import base64
import sys
from pathlib import Path

import pytest
from command_kit import refusals  # noqa: F401
from matplotlib.figure import Figure

# The example candidates of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))

ONE_PIXEL_PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mP4DwABAQEAHLCMmQAAAABJRU5ErkJggg=="
)


@pytest.fixture
def blank_figures(monkeypatch):
    """Save every figure as one pixel: drawing takes most of the time of a report."""

    def savefig(figure, target, **_):
        if isinstance(target, str):
            Path(target).write_bytes(ONE_PIXEL_PNG)
        else:
            target.write(ONE_PIXEL_PNG)

    monkeypatch.setattr(Figure, "savefig", savefig)
