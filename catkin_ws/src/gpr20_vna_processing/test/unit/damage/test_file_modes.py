"""Who may read a survey: the modes of every kind of file and folder, whatever the umask."""

from __future__ import annotations

import os
import shutil
import stat

import pytest
from fault_kit import raises_fault
from log_examples import NOW, add_marker
from storage_kit import Kit
from trace_examples import SURVEY, make_trace

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.records import record_from
from gpr20_survey.files.access import Readers
from gpr20_survey.folder.annotating import add_to_survey
from gpr20_survey.recording.recordings import open_recordings
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

EXPECTED = {
    Readers.OWNER: (0o700, 0o600),
    Readers.GROUP: (0o750, 0o640),
    Readers.ALL: (0o755, 0o644),
}


@pytest.fixture(params=[0o000, 0o077])
def umask(request):
    before = os.umask(request.param)
    yield
    os.umask(before)


def modes(top):
    """Return the modes of all folders and of all files in a folder."""
    found = [top, *top.rglob("*")]
    return [{oct(stat.S_IMODE(one.stat().st_mode)) for one in found if one.is_dir() == folders}
            for folders in (True, False)]  # fmt: skip


def damage_everything(folder):
    """Damage one file of each kind, so that each is kept and written again."""
    trace = next((folder / "traces").glob("000000_*"))
    names = ("survey.bag", "survey.mcap", "survey.json", "log.jsonl")
    for path in (trace, *(folder / name for name in names)):
        content = path.read_bytes()
        # In a recording behind what it begins with.
        place = max(content.find(b"zstd"), content.find(b"op=\x05"), len(content) // 4)
        path.write_bytes(content[:place] + bytes(100) + content[place + 100 :])


def use(kit):
    """Make every kind of file: open, store, close, damage, reopen, repair, close, reseal."""
    folder = kit.open(metadata_json='{"planned_traces": 3}')
    kit.processing.store(make_trace(0))
    kit.processing.close_survey(SURVEY, "stopped")
    damage_everything(folder)
    kit.processing.reopen_survey(SURVEY)
    kit.processing.store(make_trace(1))
    kit.processing.close_survey(SURVEY, "stopped")
    (folder / "log.jsonl").unlink()
    add_to_survey(folder, add_marker(1), NOW)
    names = {one.name for one in folder.rglob("*")}
    files = {"survey.json", "log.jsonl", "survey.bag", "survey.mcap"}
    assert {"manifest.json", "damaged", *files} <= names
    assert files <= {one.name for one in (folder / "damaged").iterdir()}
    return folder


@pytest.mark.parametrize("readers", Readers)
def test_folders_and_files_have_their_modes_whatever_the_umask(tmp_path, umask, readers):
    kit = Kit(tmp_path / "new" / "data", open_recordings, readers=readers)
    try:
        use(kit)
    finally:
        kit.processing.shut_down()
    folder_mode, file_mode = EXPECTED[readers]
    assert modes(tmp_path / "new") == [{oct(folder_mode)}, {oct(file_mode)}]


def test_a_survey_that_exists_keeps_its_modes(tmp_path):
    kit = Kit(tmp_path / "data", open_recordings, readers=Readers.ALL)
    folder = kit.open(metadata_json='{"planned_traces": 3}')
    kit.processing.store(make_trace(0))
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    damage_everything(folder)
    kit = Kit(tmp_path / "data", open_recordings, readers=Readers.OWNER)
    kit.processing.reopen_survey(SURVEY)
    kit.processing.store(make_trace(1))
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    assert modes(folder) == [{"0o755"}, {"0o644"}]


def test_a_data_folder_that_exists_keeps_its_mode(tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    data.chmod(0o1777)
    kit = Kit(data, open_recordings)
    folder = kit.open()
    kit.processing.shut_down()
    assert stat.S_IMODE(data.stat().st_mode) == 0o1777
    assert modes(folder) == [{"0o750"}, {"0o640"}]


def test_the_group_of_a_shared_folder_is_inherited(tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    groups = [one for one in os.getgroups() if one != os.getegid()]
    if groups:
        shutil.chown(str(data), group=groups[0])
    data.chmod(0o2775)
    kit = Kit(data, open_recordings)
    folder = kit.open()
    kit.processing.shut_down()
    assert {one.stat().st_gid for one in folder.rglob("*")} == {data.stat().st_gid}
    assert stat.S_IMODE(folder.stat().st_mode) == 0o2750


def test_the_parameter_is_one_of_the_three():
    assert ProcessingParameters().readable_by is Readers.GROUP
    read = record_from(ProcessingParameters, {"readable_by": "owner"}, "storage")
    assert read.readable_by is Readers.OWNER
    with raises_fault("value.not_allowed", "everyone", error=InvalidValueError):
        record_from(ProcessingParameters, {"readable_by": "everyone"}, "storage")
