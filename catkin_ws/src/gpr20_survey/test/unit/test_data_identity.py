"""The data folder: known by its marker, never made in the place of one that is gone.

Also on real disks, where this machine can mount some: unmounted, replaced, read-only, copied.
"""

import contextlib
import errno
import fcntl
import os
import shutil
import subprocess
from dataclasses import replace

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.faults import DISK_REFUSES
from gpr20_survey.errors import StorageFailedError, SurveyRefusedError
from gpr20_survey.faults import FILE_SYSTEM_UNSUITABLE, NO_DATA_DISK, OTHER_DATA_FOLDER
from gpr20_survey.files.durable_files import add_line, keep_aside
from gpr20_survey.folder.data_folder import (
    MARKER_FILE,
    ROOT,
    DataFolder,
    DataFolderUse,
    FileSystem,
    file_system_of,
    memory_file,
    read_marker,
    write_marker,
)

MEMORY_DISK = ("-t", "tmpfs", "-o", "size=4m", "tmpfs")


@pytest.fixture
def use(tmp_path):
    return DataFolderUse(tmp_path / "disk" / "data", tmp_path / "state")


@pytest.fixture
def folder(use):
    return DataFolder(use)


def content(path):
    """Return everything below a folder."""
    return sorted(str(one.relative_to(path)) for one in path.rglob("*"))


def problem_code(folder):
    found = folder.problem()
    return None if found is None else found.fault_code


def is_refused(use, folder, fault, *shown):
    """Expect that the folder is refused, now and by its diagnostics, and that nothing is made."""
    before = content(use.path.parent)
    assert problem_code(folder) == fault.code
    with raises_fault(fault, use.path, *shown):
        folder.check()
    assert content(use.path.parent) == before


def test_the_first_use_makes_and_marks_the_folder_and_every_later_one_knows_it(use, folder):
    assert folder.problem() is None and folder.identify().identity == ""
    assert not use.path.exists()
    folder.check()
    known = folder.identify()
    assert known.remembered and known.identity == read_marker(use.path).identity
    DataFolder(use).check()
    assert folder.identify() == known and folder.problem() is None
    assert content(use.path) == [MARKER_FILE]
    # Each path is remembered for itself; a folder of before this version gets a marker.
    other = replace(use, path=use.path.with_name("other"))
    (other.path / "20260921T141320_0f8fad5b").mkdir(parents=True)
    DataFolder(other).check()
    assert read_marker(other.path).identity not in ("", known.identity)


def empty(path):
    shutil.rmtree(path)
    path.mkdir()


def other(path):
    marker = read_marker(path)
    write_marker(path, replace(marker, identity="7c9e6679"), replace=True)


def copy(path):
    write_marker(path, replace(read_marker(path), file_system="uuid:0"), replace=True)


def damage(path):
    (path / MARKER_FILE).write_bytes((path / MARKER_FILE).read_bytes()[:40])


@pytest.mark.parametrize("change", [None, shutil.rmtree, empty, other, copy, damage])
def test_another_folder_in_its_place_is_refused_until_somebody_accepts_it(
    use, folder, change, monkeypatch
):
    disk = replace(file_system_of(ROOT), identity="uuid:a")
    monkeypatch.setattr("gpr20_survey.folder.data_folder.file_system_of", lambda _path: disk)
    folder.check()
    former = folder.identify().identity
    if change is not None:
        change(use.path)
        shown = {other: (former, "7c9e6679"), copy: ("copy",)}.get(change, ())
        for one in (folder, DataFolder(use)):
            is_refused(use, one, OTHER_DATA_FOLDER, *shown)
    identity = folder.accept()
    DataFolder(use).check()
    assert folder.identify().identity == identity == folder.accept()
    assert change is not copy or identity != former


def test_a_damaged_memory_does_not_count_as_a_first_use(use, folder):
    folder.check()
    memory_file(use.state, use.path).write_text("{")
    shutil.rmtree(use.path)
    is_refused(use, folder, OTHER_DATA_FOLDER)


@each_case("place", [ROOT, ROOT / "run", ROOT / "no" / "such" / "mount"])
def test_with_a_data_disk_nothing_is_stored_on_that_of_the_system_or_in_memory(tmp_path, place):
    system = file_system_of(place if place.exists() else ROOT)
    if not (system.is_same(file_system_of(ROOT)) or system.kind == "tmpfs"):
        return
    use = DataFolderUse(place / "gpr20_no_such_folder", tmp_path, own_disk=True)
    folder = DataFolder(use)
    for action in (folder.check, folder.accept, folder.identify):
        with raises_fault(NO_DATA_DISK, use.path, error=SurveyRefusedError):
            action()
    assert problem_code(folder) == NO_DATA_DISK.code
    assert not use.path.exists()


@each_case(
    "module, name, number",
    [
        (os, "link", errno.EPERM),  # FAT
        (fcntl, "flock", errno.ENOLCK),
    ],
)
def test_a_file_system_without_links_or_locks_is_refused_and_nothing_is_left(
    tmp_path, module, name, number
):
    def refuse(*_arguments, **_options):
        raise OSError(number, os.strerror(number))

    place = tmp_path / f"{name}{number}"
    place.mkdir()
    folder = DataFolder(DataFolderUse(place / "data", tmp_path / "state"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, name, refuse)
        with raises_fault(FILE_SYSTEM_UNSUITABLE, place, error=SurveyRefusedError):
            folder.check()
        assert problem_code(folder) == FILE_SYSTEM_UNSUITABLE.code
        assert content(place) == []
    assert problem_code(folder) is None
    folder.check()
    # Nor are the diagnostics a write each second.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("gpr20_survey.folder.data_folder.check_can_store", pytest.fail)
        assert [folder.problem() for _second in range(5)] == [None] * 5


def test_nothing_makes_the_data_folder_again_below_which_it_writes(tmp_path):
    gone = tmp_path / "gone"
    (tmp_path / "file").write_text("")
    with pytest.raises(FileNotFoundError):
        add_line(gone / "checks" / "history.jsonl", {"a": 1})
    with pytest.raises(FileNotFoundError):
        keep_aside(tmp_path / "file", gone / "survey" / "damaged")
    assert not gone.exists()


def test_the_first_uses_of_two_programs_agree_about_the_marker(use, folder, monkeypatch):
    second = DataFolder(use)
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
    (tmp_path / "proc/self/mounts").write_text(
        "/dev/root / ext4 rw 0 0\n"
        f"systemd-1 {point} autofs rw,fd=30 0 0\n"
        f"{device} {point} btrfs rw,subvol=/sub 0 0\n"
        f"/dev/sdc1 {point}x xfs rw 0 0\n"
    )
    found = file_system_of(data, tmp_path)
    assert (found.kind, found.identity) == ("btrfs", "uuid:1234-ABCD")
    assert found.mount_point == str(data.parent.resolve())
    assert not found.read_only


@pytest.mark.skipif(os.geteuid() == 0, reason="root may do everything")
def test_a_folder_that_this_user_may_not_write_to_is_refused(use, folder):
    folder.check()
    use.path.chmod(0o500)
    with raises_fault(DISK_REFUSES, error=StorageFailedError):
        folder.check()
    use.path.chmod(0o700)


def test_an_identity_of_another_file_system_is_recognized():
    disk = FileSystem(1, "/data", "ext4", "uuid:a", read_only=False)
    markers = ("uuid:a", "uuid:b", "")
    assert [disk.is_other_than(one) for one in markers] == [False, True, False]
    memory = replace(disk, kind="tmpfs", identity="")
    assert memory.is_other_than("uuid:a") and not memory.is_other_than("")


@contextlib.contextmanager
def mounted(path, *arguments):
    path.mkdir(exist_ok=True)
    subprocess.run(["mount", *arguments, str(path)], check=True, timeout=20)
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(path)], check=True, timeout=20)


@pytest.mark.needs("mounts")
def test_neither_the_folder_below_an_unmounted_disk_nor_another_disk_takes_its_place(use, folder):
    disk = use.path.parent
    with mounted(disk, *MEMORY_DISK):
        folder.check()
        assert folder.problem() is None
        with mounted(disk, *MEMORY_DISK):
            is_refused(use, folder, OTHER_DATA_FOLDER)
        assert folder.problem() is None
    is_refused(use, folder, OTHER_DATA_FOLDER)


@pytest.mark.needs("mounts")
def test_a_disk_that_becomes_read_only_is_refused_at_once(use, folder):
    disk = use.path.parent
    with mounted(disk, *MEMORY_DISK):
        folder.check()
        remount = ["mount", "-o", "remount,ro", str(disk)]
        subprocess.run(remount, check=True, timeout=20)
        is_refused(use, folder, DISK_REFUSES)
    fresh = DataFolder(replace(use, path=disk / "fresh"))
    with mounted(disk, *MEMORY_DISK, "-o", "ro"):
        with raises_fault(DISK_REFUSES, error=StorageFailedError):
            fresh.check()
        assert content(disk) == []
