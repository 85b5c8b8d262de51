"""What the tests of several files share."""

import base64
import shutil
import sys
from pathlib import Path

import pytest
from command_kit import refusals  # noqa: F401
from matplotlib.figure import Figure
from storage_kit import with_bag
from survey_kit import POINTS, make_survey

# The example candidates of gpr20_survey's tests.
sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey/test/unit"))

ONE_PIXEL_PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mP4DwABAQEAHLCMmQAAAABJRU5ErkJggg=="
)


@pytest.fixture(scope="session")
def finished(tmp_path_factory):
    """The folder of a survey that is complete; it is not to be changed."""
    return with_bag(make_survey(tmp_path_factory.mktemp("finished"), len(POINTS), "finished"))


@pytest.fixture(scope="session")
def stopped(tmp_path_factory):
    """The folder of a survey that was stopped after 7 traces; it is not to be changed."""
    return with_bag(make_survey(tmp_path_factory.mktemp("stopped"), 7, "stopped"))


@pytest.fixture
def copied(finished, tmp_path):
    """A copy of that folder of a survey."""
    return Path(shutil.copytree(str(finished), str(tmp_path / finished.name)))


@pytest.fixture
def blank_figures(monkeypatch):
    """Save every figure as one pixel: drawing takes most of the time of a report."""

    def savefig(figure, target, **_):
        if isinstance(target, str):
            Path(target).write_bytes(ONE_PIXEL_PNG)
        else:
            target.write(ONE_PIXEL_PNG)

    monkeypatch.setattr(Figure, "savefig", savefig)
