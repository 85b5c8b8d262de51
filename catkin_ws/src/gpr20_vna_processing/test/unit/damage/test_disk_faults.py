"""A disk that is full, and files that others may read or not."""

import os
import shutil
import stat
import subprocess

import pytest
from fault_kit import raises_fault
from log_examples import NOW, add_marker
from reopening_kit import assert_whole, trace_file
from storage_kit import Kit, with_bag
from trace_examples import SURVEY, make_trace, read_json

from gpr20_survey.errors import StorageFailedError
from gpr20_survey.files.durable_files import Readers
from gpr20_survey.files.regular_files import is_temporary
from gpr20_survey.folder.recovery import add_to_survey
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

LIMITS = ProcessingParameters(timeout_s=60.0, commit_period_s=0.05, disk_reserve_mb=0.0)


@pytest.fixture
def small_disk(tmp_path):
    """A file system of one megabyte."""
    place = tmp_path / "disk"
    place.mkdir()
    options = ["-t", "tmpfs", "-o", "size=1m,nr_inodes=400"]
    subprocess.run(["mount", *options, "gpr20-test", str(place)], check=True)
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


@pytest.mark.needs("mounts")
def test_a_survey_goes_on_after_space_was_made_on_a_full_disk(small_disk):
    kit = Kit(small_disk / "data", limits=LIMITS)
    folder = kit.open()
    ballast = small_disk / "ballast"
    ballast.write_bytes(b"\0" * 500_000)
    with raises_fault(("disk.full", "disk.refuses"), error=StorageFailedError):
        for refused in range(10_000):
            kit.processing.store(make_trace(refused))
    assert refused > 10
    for _ in range(3):
        with raises_fault("disk.full", error=StorageFailedError):
            kit.processing.store(make_trace(refused))
    assert [trace.index for trace in kit.stored] == list(range(refused))
    # Data are only whole files; at most the refused trace is beyond what was acknowledged.
    for path in (folder / "traces").iterdir():
        assert not is_temporary(path.name)
        assert read_json(path)["index"] <= refused
    ballast.unlink()
    for index in range(refused, refused + 10):
        kit.processing.store(make_trace(index))
    kit.processing.close_survey(SURVEY, "finished")
    kit.processing.shut_down()
    assert_whole(folder, [make_trace(index) for index in range(refused + 10)])


def modes(top):
    """Return the modes of all folders and of all files in a folder."""
    found = [top, *top.rglob("*")]
    return [{stat.S_IMODE(one.stat().st_mode) for one in found if one.is_dir() == folders}
            for folders in (True, False)]  # fmt: skip


def damage_everything(folder):
    """Damage one file of each kind, so that each is kept and written again."""
    names = ("survey.mcap", "log.jsonl")
    for path in (trace_file(folder, 0), *(folder / name for name in names)):
        content = path.read_bytes()
        # In a recording behind what it begins with.
        place = max(content.find(b"zstd"), len(content) // 4)
        path.write_bytes(content[:place] + bytes(100) + content[place + 100 :])


def use(kit, then=None):
    """Make every kind of file: open, store, close, damage, reopen, repair, close, reseal."""
    folder = kit.open(metadata_json='{"planned_traces": 3}')
    kit.processing.store(make_trace(0))
    kit.processing.close_survey(SURVEY, "stopped")
    damage_everything(folder)
    if then is not None:
        kit.processing.shut_down()
        kit = then
    kit.processing.reopen_survey(SURVEY)
    kit.processing.store(make_trace(1))
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    with_bag(folder)
    (folder / "log.jsonl").unlink()
    add_to_survey(folder, add_marker(1), NOW)
    names = {one.name for one in folder.rglob("*")}
    files = {"log.jsonl", "survey.mcap"}
    others = {"manifest.json", "damaged", "survey.json", "survey.bag", "log.copy.jsonl"}
    assert files | others <= names
    assert files <= {one.name for one in (folder / "damaged").iterdir()}
    return folder


def test_folders_and_files_have_their_modes_whatever_the_umask(tmp_path):
    before = os.umask(0o077)
    try:
        use(Kit(tmp_path / "top" / "data", readers=Readers.GROUP))
    finally:
        os.umask(before)
    assert modes(tmp_path / "top") == [{0o750}, {0o640}]


def test_a_survey_and_a_data_folder_that_exist_keep_their_modes_and_group(tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    groups = [one for one in os.getgroups() if one != os.getegid()]
    if groups:
        shutil.chown(str(data), group=groups[0])
    data.chmod(0o2775)
    first, second = (Kit(data, readers=one) for one in (Readers.ALL, Readers.OWNER))
    folder = use(first, second)
    assert modes(folder) == [{0o2755}, {0o644}]
    assert {one.stat().st_gid for one in folder.rglob("*")} == {data.stat().st_gid}
    assert stat.S_IMODE(data.stat().st_mode) == 0o2775
