"""A disk that is full, and files that others may read or not."""

import os
import shutil
import stat
import subprocess

import pytest
from fault_kit import raises_fault
from reopening_kit import assert_whole, trace_file
from storage_kit import Kit, with_bag
from trace_examples import SURVEY, make_trace, read_json

from gpr20_survey.errors import StorageFailedError
from gpr20_survey.files.durable_files import Readers
from gpr20_survey.files.regular_files import is_temporary
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


def use(kit, then=None):
    """Make every kind of file: open, store, close, damage, reopen, repair, close, make a bag."""
    folder = kit.open(metadata_json='{"planned_traces": 3}')
    kit.processing.store(make_trace(0))
    kit.processing.close_survey(SURVEY, "stopped")
    for path in (trace_file(folder, 0), folder / "survey.mcap", folder / "log.jsonl"):
        path.write_bytes(path.read_bytes()[:-9])
    if then is not None:
        kit.processing.shut_down()
        kit = then
    kit.processing.reopen_survey(SURVEY)
    kit.processing.close_survey(SURVEY, "stopped")
    kit.processing.shut_down()
    names = {one.name for one in with_bag(folder).rglob("*")}
    assert {"manifest.json", "survey.json", "survey.bag", "log.jsonl", "log.copy.jsonl"} <= names
    assert list((folder / "damaged").iterdir())
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
