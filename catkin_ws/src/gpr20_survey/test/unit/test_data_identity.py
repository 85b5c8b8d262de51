"""The data folder: known by its marker, never made in the place of one that is gone."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
from dataclasses import replace

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.low.clock import Clock
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.faults import (
    FILE_SYSTEM_UNSUITABLE,
    NO_DATA_DISK,
    NOT_A_FILE,
    NOT_PERMITTED,
    OTHER_DATA_FOLDER,
)
from gpr20_survey.files.data_marker import MARKER_FILE, FolderMemory, read_marker, write_marker
from gpr20_survey.files.durable_files import keep_aside
from gpr20_survey.files.file_system import ROOT, FileSystem, file_system_of
from gpr20_survey.files.json_lines import add_line
from gpr20_survey.folder.data_folder import RETRY_S, DataFolder, DataFolderUse


class SteppedClock(Clock):
    """Goes on when a test says so."""

    time_s = 0.0

    def now_s(self):
        return self.time_s


@pytest.fixture
def use(tmp_path):
    return DataFolderUse(tmp_path / "disk" / "data", tmp_path / "state")


@pytest.fixture
def folder(use):
    return DataFolder(use, SteppedClock())


def content(path):
    """Return everything below a folder."""
    return sorted(str(one.relative_to(path)) for one in path.rglob("*"))


def problem_code(folder):
    found = folder.problem()
    return None if found is None else found.fault_code


def test_the_first_use_makes_and_marks_the_folder_and_every_later_one_knows_it(use, folder):
    assert folder.problem() is None and folder.identify().identity == ""
    assert not use.path.exists()
    folder.check()
    known = folder.identify()
    assert known.remembered and known.identity == read_marker(use.path).identity
    for _again in range(3):
        DataFolder(use, Clock()).check()
    assert folder.identify() == known and folder.problem() is None
    assert content(use.path) == [MARKER_FILE]


def test_a_folder_of_before_this_version_gets_a_marker(use, folder):
    (use.path / "20260921T141320_0f8fad5b").mkdir(parents=True)
    folder.check()
    assert folder.identify().remembered


def remove(path):
    shutil.rmtree(path)


def empty(path):
    shutil.rmtree(path)
    path.mkdir()


def other(path):
    marker = read_marker(path)
    write_marker(path, replace(marker, identity="7c9e6679"), replace=True)


def copy(path):
    marker = read_marker(path)
    kind = file_system_of(path).identity.partition(":")[0] or "uuid"
    write_marker(path, replace(marker, file_system=f"{kind}:0"), replace=True)


def damage(path):
    (path / MARKER_FILE).write_bytes((path / MARKER_FILE).read_bytes()[:40])


@each_case("change", [remove, empty, other, damage])
def test_another_folder_in_its_place_is_refused_and_nothing_is_made(tmp_path, change):
    use = DataFolderUse(tmp_path / change.__name__ / "data", tmp_path / "state")
    folder = DataFolder(use, Clock())
    folder.check()
    change(use.path)
    before = content(tmp_path)
    assert problem_code(folder) == OTHER_DATA_FOLDER.code
    for one in (folder, DataFolder(use, Clock())):
        with raises_fault(OTHER_DATA_FOLDER, use.path, error=SurveyRefusedError):
            one.check()
    assert content(tmp_path) == before


def test_the_refusal_names_the_expected_and_the_found_identity(use, folder):
    folder.check()
    expected = folder.identify().identity
    other(use.path)
    with raises_fault(OTHER_DATA_FOLDER, use.path, expected, "7c9e6679"):
        folder.check()


def test_a_copy_on_another_file_system_is_not_the_original(use, folder):
    folder.check()
    if not file_system_of(use.path).identity:
        pytest.skip("this file system has no identity")
    copy(use.path)
    with raises_fault(OTHER_DATA_FOLDER, "copy"):
        folder.check()
    former = read_marker(use.path).identity
    assert folder.accept() != former


@each_case("change", [None, remove, empty, other, copy, damage])
def test_what_somebody_accepts_is_used_from_then_on(tmp_path, change):
    use = DataFolderUse(tmp_path / str(change) / "data", tmp_path / "state")
    folder = DataFolder(use, Clock())
    folder.check()
    if change is not None:
        change(use.path)
    identity = folder.accept()
    DataFolder(use, Clock()).check()
    assert folder.identify().identity == identity == folder.accept()


def test_a_damaged_memory_does_not_count_as_a_first_use(use, folder):
    folder.check()
    FolderMemory(use.state).file_of(use.path).write_text("{")
    remove(use.path)
    with raises_fault(OTHER_DATA_FOLDER, use.path):
        folder.check()
    assert not use.path.exists()


def test_a_link_or_a_pipe_in_the_place_of_the_marker_is_refused_without_waiting(use, folder):
    folder.check()
    (use.path / MARKER_FILE).unlink()
    os.mkfifo(use.path / MARKER_FILE)
    with raises_fault(NOT_A_FILE, error=StorageFailedError):
        folder.check()


def test_each_path_is_remembered_for_itself(tmp_path):
    one, two = (DataFolderUse(tmp_path / name, tmp_path / "state") for name in ("one", "two"))
    DataFolder(one, Clock()).check()
    DataFolder(two, Clock()).check()
    assert read_marker(one.path).identity != read_marker(two.path).identity


@each_case("place", [ROOT, ROOT / "run", ROOT / "no" / "such" / "mount"])
def test_with_a_data_disk_nothing_is_stored_on_that_of_the_system_or_in_memory(tmp_path, place):
    system = file_system_of(place if place.exists() else ROOT)
    if not (system.is_same(file_system_of(ROOT)) or system.kind == "tmpfs"):
        return
    use = DataFolderUse(place / "gpr20_no_such_folder", tmp_path, own_disk=True)
    folder = DataFolder(use, Clock())
    for action in (folder.check, folder.accept, folder.identify):
        with raises_fault(NO_DATA_DISK, use.path, error=SurveyRefusedError):
            action()
    assert problem_code(folder) == NO_DATA_DISK.code
    assert not use.path.exists()


@each_case(
    "module, name, number",
    [
        (os, "link", errno.EPERM),  # FAT, exFAT
        (os, "link", errno.EOPNOTSUPP),
        (os, "link", errno.ENOSYS),
        (fcntl, "flock", errno.ENOLCK),
        (fcntl, "flock", errno.EOPNOTSUPP),
        (fcntl, "flock", errno.EBADF),  # some network mounts
    ],
)
def test_a_file_system_without_links_or_locks_is_refused_and_nothing_is_left(
    tmp_path, module, name, number
):
    def refuse(*_arguments, **_options):
        raise OSError(number, os.strerror(number))

    place = tmp_path / f"{name}{number}"
    place.mkdir()
    clock = SteppedClock()
    folder = DataFolder(DataFolderUse(place / "data", tmp_path / "state"), clock)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, name, refuse)
        with raises_fault(FILE_SYSTEM_UNSUITABLE, place, error=SurveyRefusedError):
            folder.check()
        assert problem_code(folder) == FILE_SYSTEM_UNSUITABLE.code
        assert content(place) == []
    # It is not tried each second, but again after a while.
    assert problem_code(folder) == FILE_SYSTEM_UNSUITABLE.code
    clock.time_s += RETRY_S
    assert problem_code(folder) is None
    folder.check()


def test_the_diagnostics_write_nothing_each_second(use, folder, monkeypatch):
    folder.check()
    assert folder.problem() is None
    monkeypatch.setattr("gpr20_survey.folder.data_folder.check_can_store", pytest.fail)
    for _second in range(5):
        assert folder.problem() is None


def test_nothing_makes_the_data_folder_again_below_which_it_writes(tmp_path):
    gone = tmp_path / "gone"
    (tmp_path / "file").write_text("")
    with pytest.raises(FileNotFoundError):
        add_line(gone / "checks" / "history.jsonl", {"a": 1})
    with pytest.raises(FileNotFoundError):
        keep_aside(tmp_path / "file", gone / "survey" / "damaged")
    assert not gone.exists()


def test_the_first_uses_of_two_programs_agree_about_the_marker(use, folder, monkeypatch):
    second = DataFolder(use, Clock())
    real = write_marker

    def second_first(path, marker, replace=False):
        monkeypatch.setattr("gpr20_survey.folder.data_folder.write_marker", real)
        second.check()
        real(path, marker, replace)

    monkeypatch.setattr("gpr20_survey.folder.data_folder.write_marker", second_first)
    folder.check()
    assert folder.identify() == second.identify()


def test_the_mount_table_and_udev_say_which_file_system_it_is(tmp_path):
    data = tmp_path / "my disk" / "data"
    data.mkdir(parents=True)
    device = tmp_path / "dev" / "sda1"
    links = tmp_path / "dev/disk/by-uuid"
    links.mkdir(parents=True)
    device.write_text("")
    (links / "1234-ABCD").symlink_to(device)
    (links / "gone").symlink_to(tmp_path / "dev" / "sdb1")
    (tmp_path / "proc/self").mkdir(parents=True)
    point = str(data.parent.resolve()).replace(" ", "\\040")
    (tmp_path / "proc/self/mountinfo").write_text(
        "22 1 8:1 / / rw - ext4 /dev/root rw\n"
        f"23 22 0:30 / {point} rw shared:1 - autofs systemd-1 rw\n"
        f"24 23 0:31 /sub {point} rw - btrfs {device} rw\n"
        f"25 22 0:32 / {point}x rw - xfs /dev/sdc1 rw\n"
    )
    found = file_system_of(data, tmp_path)
    assert (found.kind, found.identity) == ("btrfs", "uuid:1234-ABCD")
    assert found.mount_point == str(data.parent.resolve())
    assert not found.read_only


@pytest.mark.skipif(os.geteuid() == 0, reason="root may do everything")
def test_a_folder_that_this_user_may_not_write_to_is_refused(use, folder):
    folder.check()
    use.path.chmod(0o500)
    with raises_fault(NOT_PERMITTED, error=StorageFailedError):
        folder.check()
    use.path.chmod(0o700)


@each_case(
    "kind, identity, marked, other",
    [
        ("ext4", "uuid:a", "uuid:a", False),
        ("ext4", "uuid:a", "uuid:b", True),
        ("ext4", "uuid:a", "fsid:b", False),  # found out in another way
        ("ext4", "uuid:a", "", False),
        ("tmpfs", "", "", False),
        ("tmpfs", "", "uuid:a", True),  # a copy in memory
    ],
)
def test_an_identity_of_another_file_system_is_recognized(kind, identity, marked, other):
    system = FileSystem(1, "/data", kind, identity, read_only=False)
    assert system.is_other_than(marked) is other
