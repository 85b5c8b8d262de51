"""Makes the example traces of gpr20_survey's tests available to these, and storages."""

import contextlib
import itertools
import shutil
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[3] / "gpr20_survey" / "test" / "unit"))

from reopening_kit import STORED, make
from storage_kit import Kit

from gpr20_survey.errors import StorageFailedError


@pytest.fixture
def data(tmp_path):
    """The data folder of `kit`; a file with surveys that exist has its own."""
    return tmp_path / "data"


@pytest.fixture
def kit(data):
    """Yield a storage with a bag and an MCAP."""
    kit = Kit(data)
    yield kit
    kit.processing.shut_down()


@pytest.fixture
def kits(tmp_path):
    """Makes storages over the same data folder, each beside the former ones."""
    made = []

    def make_kit(**options):
        made.append(Kit(tmp_path / "data", **options))
        return made[-1]

    yield make_kit
    for kit in made:
        with contextlib.suppress(StorageFailedError):  # it has ended
            kit.processing.shut_down()


@pytest.fixture(scope="session")
def surveys(tmp_path_factory):
    """A survey for each way in which one ends; nobody changes them."""
    return {ending: make(tmp_path_factory.mktemp("whole"), ending) for ending in STORED}


@pytest.fixture
def copies(surveys, tmp_path):
    """Gives copies of these surveys, each alone in a data folder."""
    numbers = itertools.count()

    def copy(ending):
        place = tmp_path / f"copy{next(numbers)}" / "data"
        shutil.copytree(str(surveys[ending].folder.parent), str(place))
        return place / surveys[ending].folder.name

    return copy
