"""The data folder on real disks: unmounted, replaced, read-only, copied."""

from __future__ import annotations

import contextlib
import shutil
import subprocess
from dataclasses import replace

import pytest
from fault_kit import raises_fault
from test_data_identity import content, problem_code

from gpr20_common.faults import DISK_REFUSES
from gpr20_common.low.clock import Clock
from gpr20_survey.errors import StorageFailedError
from gpr20_survey.faults import NO_DATA_DISK, OTHER_DATA_FOLDER
from gpr20_survey.files.file_system import check_can_store, file_system_of
from gpr20_survey.folder.data_folder import DataFolder, DataFolderUse

pytestmark = pytest.mark.needs("mounts")
MEMORY_DISK = ("-t", "tmpfs", "-o", "size=4m", "tmpfs")


@pytest.fixture
def use(tmp_path):
    return DataFolderUse(tmp_path / "disk" / "data", tmp_path / "state")


@pytest.fixture
def folder(use):
    return DataFolder(use, Clock())


@contextlib.contextmanager
def mounted(path, *arguments):
    path.mkdir(exist_ok=True)
    subprocess.run(["mount", *arguments, str(path)], check=True, timeout=20)
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(path)], check=True, timeout=20)


def test_a_disk_that_is_unmounted_is_not_replaced_by_the_folder_below_it(use, folder):
    disk = use.path.parent
    disk.mkdir()
    with mounted(disk, *MEMORY_DISK):
        folder.check()
        assert folder.problem() is None
    assert problem_code(folder) == OTHER_DATA_FOLDER.code
    with raises_fault(OTHER_DATA_FOLDER, use.path):
        folder.check()
    assert content(disk) == []


def test_another_disk_in_its_place_is_refused(use, folder):
    disk = use.path.parent
    disk.mkdir()
    with mounted(disk, *MEMORY_DISK):
        folder.check()
        with mounted(disk, *MEMORY_DISK):
            assert problem_code(folder) == OTHER_DATA_FOLDER.code
            with raises_fault(OTHER_DATA_FOLDER, use.path):
                folder.check()
            assert content(disk) == []
        assert folder.problem() is None


def test_a_disk_that_becomes_read_only_is_refused_at_once(use, folder):
    disk = use.path.parent
    with mounted(disk, *MEMORY_DISK):
        folder.check()
        remount = ["mount", "-o", "remount,ro", str(disk)]
        subprocess.run(remount, check=True, timeout=20)
        assert problem_code(folder) == DISK_REFUSES.code
        with raises_fault(DISK_REFUSES, use.path, error=StorageFailedError):
            folder.check()
    fresh = DataFolder(replace(use, path=disk / "fresh"), Clock())
    with mounted(disk, *MEMORY_DISK, "-o", "ro"):
        with raises_fault(DISK_REFUSES, error=StorageFailedError):
            fresh.check()
        assert content(disk) == []


def test_the_identity_of_an_ext4_outlives_a_remount_and_tells_it_from_its_copy(tmp_path, use):
    image, disk = tmp_path / "image", use.path.parent
    loop = ("-o", "loop", str(image))
    with image.open("wb") as file:
        file.truncate(8 << 20)
    made = subprocess.run(["mkfs.ext4", "-q", str(image)], check=False, timeout=60)
    if made.returncode:
        pytest.skip("no mkfs.ext4 here")
    disk.mkdir()
    own = replace(use, own_disk=True)
    with mounted(disk, *loop):
        DataFolder(own, Clock()).check()
        check_can_store(use.path)
        identity = file_system_of(use.path).identity
        copied = shutil.copytree(use.path, tmp_path / "copied")
    with mounted(disk, *loop):
        DataFolder(own, Clock()).check()
        assert file_system_of(use.path).identity == identity != ""
    with raises_fault(NO_DATA_DISK):
        DataFolder(own, Clock()).check()
    shutil.copytree(copied, use.path)
    if file_system_of(use.path).identity:
        with raises_fault(OTHER_DATA_FOLDER, "copy"):
            DataFolder(use, Clock()).check()
