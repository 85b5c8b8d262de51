"""START stores nothing in a folder that is not the data folder, or on an unsuitable disk."""

import errno
import fcntl
import os

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from storage_kit import OTHER_SURVEY, Kit, MemoryRecording
from trace_examples import SURVEY

from gpr20_common.low.clock import Clock
from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.faults import FILE_SYSTEM_UNSUITABLE, OTHER_DATA_FOLDER
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse


@pytest.fixture
def data(tmp_path):
    return tmp_path / "disk" / "data"


@pytest.fixture
def kit(data, tmp_path):
    folder = DataFolder(DataFolderUse(data, tmp_path / "state"), Clock())
    kit = Kit(data, lambda *_: [MemoryRecording()], check_data=folder.check)
    yield kit
    kit.processing.shut_down()


def refusals(kit, fault):
    """Expect that neither a new survey nor one that was cut off is opened."""
    with raises_fault(fault, error=SurveyRefusedError):
        kit.open(OTHER_SURVEY)
    with raises_fault(fault, error=SurveyRefusedError):
        kit.processing.reopen_survey(SURVEY)


def test_a_data_folder_that_is_moved_away_while_the_robot_runs_is_not_made_again(kit, data):
    kit.open()
    kit.processing.close_survey(SURVEY, "stopped")
    data.rename(data.with_name("moved"))
    refusals(kit, OTHER_DATA_FOLDER)
    assert not data.exists()
    data.mkdir()
    refusals(kit, OTHER_DATA_FOLDER)
    assert os.listdir(data) == []
    data.rmdir()
    data.with_name("moved").rename(data)
    assert kit.open(OTHER_SURVEY).parent == data


@each_case(
    "module, name, number",
    [(os, "link", errno.EPERM), (fcntl, "flock", errno.ENOLCK), (fcntl, "flock", errno.EOPNOTSUPP)],
)
def test_a_disk_without_links_or_locks_is_refused_before_any_folder_is_made(
    kit, data, module, name, number
):
    def refuse(*_arguments, **_options):
        raise OSError(number, os.strerror(number))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, name, refuse)
        refusals(kit, FILE_SYSTEM_UNSUITABLE)
        assert not data.exists()
