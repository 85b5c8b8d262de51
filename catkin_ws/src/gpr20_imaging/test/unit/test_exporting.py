"""What is exported to a USB stick is there as a whole, or not at all; which sticks there are."""

import errno
import hashlib
import json
import os
import subprocess
import zipfile
from dataclasses import replace

import pytest
from fault_kit import raises_fault
from imaging_kit import store_survey

from gpr20_common.faults import FILE_DAMAGED, IN_USE, NOT_ALLOWED, NOT_SET_UP
from gpr20_imaging import faults
from gpr20_imaging.faults import ImagingError
from gpr20_imaging.low import stick_files
from gpr20_imaging.low.stick_files import UsbVolumes
from gpr20_imaging.mid import exporting
from gpr20_imaging.mid.exporting import FOLDER, Exporter, ExportRequest
from gpr20_survey.results.answers import ExportPart

REPORT, ZIP = ExportPart.REPORT_HTML, ExportPart.SURVEY_ZIP


@pytest.fixture
def stages():
    return []


@pytest.fixture
def exporter(analysis, sticks, stages):
    return Exporter(analysis, sticks.volumes, stages.append)


@pytest.fixture
def folder(tmp_path):
    return store_survey(tmp_path / "data")


@pytest.fixture
def stick(sticks):
    return sticks.plug_in()


def request_for(folder, stick, *kinds, simulated=True):
    return ExportRequest(folder, simulated, kinds, 4.0, "es", str(stick))


@pytest.fixture
def export(exporter, folder, stick):
    """Return a function that exports the survey to the stick."""
    return lambda *kinds: exporter.export(request_for(folder, stick, *kinds))


def files_of(stick):
    return sorted(one.name for one in (stick / FOLDER).glob("*")) if stick.is_dir() else []


def at_copy(monkeypatch, before=lambda: None, after=lambda: None):
    """Let something happen whenever a file is copied to the stick."""
    real = exporting.copyfileobj

    def copy(source, target):
        before()
        real(source, target)
        after()

    monkeypatch.setattr(exporting, "copyfileobj", copy)


def at_write(monkeypatch, then):
    """Let something happen before each part that is written to the stick."""
    real = stick_files.SummedFile.write

    def write(self, data):
        then()
        return real(self, data)

    monkeypatch.setattr(stick_files.SummedFile, "write", write)


def test_every_kind_is_written_with_its_checksum(export, folder, stick, stages):
    names = export(*ExportPart)
    assert [one.split("_", 2)[2] for one in names] == [
        f"SIMULATED_{kind.value.replace('-', '.')}" for kind in ExportPart
    ]
    for name in names:
        content = (stick / name).read_bytes()
        line = (stick / (name + ".sha256")).read_text()
        assert line == f"{hashlib.sha256(content).hexdigest()}  {name.split('/')[1]}\n"
    assert len(files_of(stick)) == 2 * len(names)
    assert (stick / names[0]).read_text().startswith(f"{folder} 4.0 es")
    assert len(stages) == 2 * len(names) + 1  # and what was stored is read


def test_the_zip_file_holds_the_whole_survey_and_replaces_a_former_one(
    exporter, folder, stick, tmp_path
):
    wanted = request_for(folder, stick, ZIP, simulated=False)
    (name,) = exporter.export(wanted)
    assert "SIMULATED" not in name
    with zipfile.ZipFile(str(stick / name)) as archive:
        assert archive.testzip() is None
        archive.extractall(str(tmp_path / "copy"))
    for path in (one for one in folder.rglob("*") if one.is_file()):
        copy = tmp_path / "copy" / path.relative_to(folder.parent)
        assert copy.read_bytes() == path.read_bytes()
    (folder / "traces" / "000009.json").write_text("{}")
    # What an interrupted export left is removed, and nothing of others.
    (stick / FOLDER / f"{stick_files.TEMPORARY}0011aabb").write_text("half")
    (stick / FOLDER / ".letter.odt.tmp").write_text("of others")
    exporter.export(wanted)
    assert len(zipfile.ZipFile(str(stick / name)).namelist()) == 6
    assert len(files_of(stick)) == 3 and ".letter.odt.tmp" in files_of(stick)


def test_without_a_stick_one_file_of_the_analysis_is_in_the_answer(exporter, folder):
    for kind in (one for one in ExportPart if one is not ZIP):
        name, content = exporter.make(request_for(folder, "", kind))
        assert name == f"{folder.name}_SIMULATED_{kind.value.replace('-', '.')}"
        assert content.decode().startswith(f"{folder} 4.0 es")
    for kinds in ((ZIP,), (ExportPart.CANDIDATES_CSV, REPORT)):
        with raises_fault(NOT_ALLOWED, error=ImagingError):
            exporter.make(request_for(folder, "", *kinds))


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EFBIG, errno.EACCES])
def test_no_file_has_its_name_when_the_stick_fails(export, stick, monkeypatch, number):
    for at in range(4):
        left = [None] * at

        def fail(left=left):
            if not left:
                raise OSError(number, os.strerror(number))
            left.pop()

        with monkeypatch.context() as patched:
            at_write(patched, fail)
            with raises_fault(faults.STICK, stick.name):
                export(ZIP)
        assert files_of(stick) == [], at


@pytest.fixture
def small_stick(sticks):
    """A stick with a file system of its own of 3 MB."""
    path = sticks.plug_in("SMALL")
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(path)], check=True)
    yield path
    subprocess.run(["umount", "--lazy", str(path)], check=True)


@pytest.mark.needs("mounts")
def test_a_file_system_that_becomes_full_or_goes_away_keeps_only_whole_files(
    folder, exporter, small_stick, monkeypatch
):
    (folder / "survey.bag").write_bytes(os.urandom(5_000_000))
    with raises_fault(faults.STICK, small_stick.name):
        exporter.export(request_for(folder, small_stick, REPORT, ZIP))
    left = files_of(small_stick)
    assert [one.split("SIMULATED_")[1] for one in left] == ["report.html", "report.html.sha256"]
    unmount = ["umount", "--lazy", str(small_stick)]
    at_copy(monkeypatch, after=lambda: subprocess.run(unmount, check=True))
    # It is still listed, as another device: that of the folder below.
    with raises_fault(faults.STICK, small_stick):
        exporter.export(request_for(folder, small_stick, REPORT))
    assert files_of(small_stick) == []
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(small_stick)], check=True)


def test_a_full_stick_is_refused_first(export, stick, monkeypatch):
    real = os.statvfs(str(stick))
    full = os.statvfs_result((*real[:4], 1, *real[5:]))
    monkeypatch.setattr(os, "statvfs", lambda _path: full)
    with raises_fault(faults.STICK, stick.name):
        export(REPORT)
    assert files_of(stick) == []


def test_another_stick_at_the_same_place_is_refused(sticks, stick):
    volume = sticks.volumes.find(str(stick))
    with raises_fault(faults.STICK, stick):
        stick_files.StickFolder(replace(volume, device=volume.device + 1), FOLDER)
    assert list(stick.iterdir()) == []


def contents(folder):
    return {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}


PUT = {
    "a link": lambda path, computer: path.symlink_to(computer),
    "a link to nothing": lambda path, computer: path.symlink_to(computer / "nothing"),
    "a file": lambda path, _computer: path.write_text("a file"),
    "a pipe": lambda path, _computer: os.mkfifo(str(path)),
}


@pytest.mark.parametrize("put", PUT)
def test_a_folder_of_exports_that_is_none_of_the_stick_is_refused(export, stick, tmp_path, put):
    computer = tmp_path / "computer"
    computer.mkdir()
    (computer / f"{stick_files.TEMPORARY}0011aabb").write_text("of the computer")
    before = contents(computer)
    PUT[put](stick / FOLDER, computer)
    with raises_fault(faults.STICK, stick.name):
        export(*ExportPart)
    assert contents(computer) == before
    assert [one.name for one in stick.iterdir()] == [FOLDER]


def test_links_are_replaced_not_followed_also_what_is_put_there_meanwhile(
    export, folder, stick, tmp_path, monkeypatch
):
    (stick / FOLDER).mkdir()
    computer = tmp_path / "computer"
    computer.mkdir()
    target = computer / "file"
    target.write_text("of the computer")
    for kind in ExportPart:
        name = request_for(folder, stick).name(kind)
        for ending in ("", ".sha256"):
            (stick / FOLDER / f"{name}{ending}").symlink_to(target)
    for name in export(*ExportPart):
        assert not (stick / name).is_symlink() and not (stick / f"{name}.sha256").is_symlink()

    def put_link():
        stick.rename(stick.with_name("moved"))
        stick.symlink_to(computer)

    at_copy(monkeypatch, before=put_link)
    with pytest.raises(ImagingError):
        export(REPORT)
    assert contents(computer) == {target: b"of the computer"}


SPOIL = {
    "cut": lambda path: os.truncate(str(path), 3),
    "change": lambda path: path.write_bytes(path.read_bytes()[::-1]),
    "lose": os.unlink,
}


@pytest.mark.parametrize("spoil", SPOIL)
@pytest.mark.parametrize("ending", ["", ".sha256"])
def test_what_is_not_on_the_stick_after_all_is_no_success(
    export, folder, stick, monkeypatch, spoil, ending
):
    path = stick / FOLDER / (request_for(folder, stick).name(ZIP) + ending)
    monkeypatch.setattr(stick_files.StickFolder, "sync", lambda _self: SPOIL[spoil](path))
    with raises_fault(faults.STICK, stick.name):
        export(ZIP)


def test_a_survey_that_cannot_be_read_or_changes_is_no_fault_of_the_stick(
    export, folder, stick, analysis, tmp_path, monkeypatch
):
    analysis.mode = "refuse"
    with raises_fault("test.refused"):
        export(REPORT)
    (tmp_path / "file").write_text("elsewhere")
    for put in ("a link", "a pipe"):
        PUT[put](folder / "survey.bag", tmp_path / "file")
        with raises_fault(FILE_DAMAGED, "survey.bag", error=ImagingError):
            export(ZIP)
        (folder / "survey.bag").unlink()
    at_write(monkeypatch, lambda: (folder / "survey.json").write_text("{}"))
    with raises_fault(IN_USE, error=ImagingError):
        export(ZIP)
    assert files_of(stick) == []


def listed(*devices):
    return json.dumps({"blockdevices": devices})


def test_mounted_sticks_are_listed_and_disks_of_the_system_are_not(sticks, tmp_path):
    here = str(tmp_path)
    for mark, count in (
        *((one, 1) for one in ({"rm": "1"}, {"rm": True}, {"hotplug": "1"}, {"tran": "usb"})),
        ({"rm": "0", "tran": "sata"}, 0),
        *(({"rm": True, "mountpoint": one}, 0) for one in (None, "/", "/boot/firmware")),
    ):
        device = {"name": "sda1", "label": None, "mountpoint": here, **mark}
        volumes = UsbVolumes(lambda device=device: listed(device), (tmp_path.parent,))
        assert [one.name for one in volumes.mounted()] == ["sda1"] * count, mark
    path = sticks.plug_in("BLUE")
    (found,) = sticks.volumes.mounted()
    assert (found.path, found.name, found.writable) == (str(path), "BLUE", True)
    assert found.free_bytes > 0
    path.rmdir()  # it is pulled out while it is listed
    assert sticks.volumes.mounted() == []


def test_a_stick_that_is_not_there_and_a_broken_list_are_errors(sticks, monkeypatch):
    with raises_fault(faults.STICK):
        sticks.volumes.find("/media/BLUE")
    assert isinstance(UsbVolumes(stick_files.list_block_devices).mounted(), list)
    for text in ("", "[]", '{"blockdevices": [1]}', '{"blockdevices": 3}'):
        with raises_fault(NOT_SET_UP):
            UsbVolumes(lambda text=text: text).mounted()
    monkeypatch.setattr(stick_files, "COMMAND", ("no-such-lsblk",))
    with raises_fault(NOT_SET_UP):
        UsbVolumes(stick_files.list_block_devices).mounted()
