import errno
import hashlib
import os
import subprocess
import threading
import zipfile

import pytest
from fault_kit import raises_fault
from imaging_kit import store_survey

from gpr20_imaging import faults
from gpr20_imaging.errors import CancelledError, ExportFailedError
from gpr20_imaging.low import stick_files
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.mid.export_kind import ExportKind
from gpr20_imaging.mid.exporting import FOLDER, Exporter, ExportRequest


@pytest.fixture
def stages():
    return []


@pytest.fixture
def exporter(analysis, sticks, stages):
    return Exporter(analysis.process, sticks.volumes, stages.append)


def request_for(folder, stick, *kinds, simulated=True):
    return ExportRequest(folder, simulated, kinds, 4.0, "es", str(stick))


def files_of(stick):
    return sorted(one.name for one in (stick / FOLDER).glob("*")) if stick.is_dir() else []


def test_every_kind_is_written_with_its_checksum(tmp_path, exporter, sticks, stages):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    names = exporter.export(request_for(folder, stick, *ExportKind), Cancellation())
    assert [one.split("_", 2)[2] for one in names] == [
        f"SIMULATED_{kind.ending}" for kind in ExportKind
    ]
    for name in names:
        content = (stick / name).read_bytes()
        line = (stick / (name + ".sha256")).read_text()
        assert line == f"{hashlib.sha256(content).hexdigest()}  {name.split('/')[1]}\n"
    assert len(files_of(stick)) == 2 * len(names)
    report = (stick / names[0]).read_text()
    assert report.startswith(f"{folder} 4.0 es")
    assert len(stages) == 2 * len(names)


def test_the_zip_file_holds_the_whole_survey(tmp_path, exporter, sticks):
    folder, stick = store_survey(tmp_path / "data", simulated=False), sticks.plug_in()
    (name,) = exporter.export(
        request_for(folder, stick, ExportKind.SURVEY_ZIP, simulated=False), Cancellation()
    )
    assert "SIMULATED" not in name
    with zipfile.ZipFile(str(stick / name)) as archive:
        assert archive.testzip() is None
        archive.extractall(str(tmp_path / "copy"))
    for path in (one for one in folder.rglob("*") if one.is_file()):
        copy = tmp_path / "copy" / path.relative_to(folder.parent)
        assert copy.read_bytes() == path.read_bytes()


def test_a_second_export_replaces_the_first(tmp_path, exporter, sticks):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    wanted = request_for(folder, stick, ExportKind.SURVEY_ZIP)
    exporter.export(wanted, Cancellation())
    (folder / "traces" / "000009.json").write_text("{}")
    (name,) = exporter.export(wanted, Cancellation())
    assert len(zipfile.ZipFile(str(stick / name)).namelist()) == 5
    assert len(files_of(stick)) == 2


@pytest.mark.parametrize(
    ("number", "fault"),
    [
        (errno.ENOSPC, faults.STICK_FULL),
        (errno.EIO, faults.STICK_FAILED),
        (errno.ENODEV, faults.STICK_FAILED),
        (errno.EDQUOT, faults.STICK_FAILED),
        (errno.EFBIG, faults.STICK_FORMAT),
    ],
)
@pytest.mark.parametrize("at", [0, 1, 2, 3])
def test_no_file_has_its_name_when_the_stick_fails(
    tmp_path, exporter, sticks, monkeypatch, number, fault, at
):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    written = []
    real = stick_files.SummedFile.write

    def write(self, data):
        written.append(data)
        if len(written) > at:
            raise OSError(number, os.strerror(number))
        return real(self, data)

    monkeypatch.setattr(stick_files.SummedFile, "write", write)
    with raises_fault(fault, stick.name, error=ExportFailedError):
        exporter.export(request_for(folder, stick, ExportKind.SURVEY_ZIP), Cancellation())
    assert files_of(stick) == []


@pytest.fixture
def small_stick(sticks):
    """A stick with a file system of its own of 3 MB."""
    path = sticks.plug_in("SMALL")
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", str(path)], check=True)
    yield path
    subprocess.run(["umount", "--lazy", str(path)], check=True)


@pytest.mark.needs("mounts")
def test_a_file_system_that_becomes_full_keeps_only_whole_files(tmp_path, exporter, small_stick):
    folder = store_survey(tmp_path / "data")
    (folder / "survey.bag").write_bytes(os.urandom(5_000_000))
    wanted = (ExportKind.REPORT_HTML, ExportKind.SURVEY_ZIP)
    with raises_fault(faults.STICK_FULL, small_stick.name, error=ExportFailedError):
        exporter.export(request_for(folder, small_stick, *wanted), Cancellation())
    left = files_of(small_stick)
    assert [one.split("SIMULATED_")[1] for one in left] == ["report.html", "report.html.sha256"]


@pytest.mark.needs("mounts")
def test_a_file_system_that_goes_away_is_noticed(
    tmp_path, exporter, sticks, small_stick, monkeypatch
):
    folder = store_survey(tmp_path / "data")
    real = stick_files.copy_file

    def copy(source, target):
        real(source, target)
        subprocess.run(["umount", "--lazy", str(small_stick)], check=True)

    monkeypatch.setattr(stick_files, "copy_file", copy)
    # It is still listed, as another device: that of the folder below.
    with raises_fault(faults.STICK_GONE, small_stick):
        exporter.export(request_for(folder, small_stick, ExportKind.REPORT_HTML), Cancellation())
    assert files_of(small_stick) == []
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(small_stick)], check=True)


def test_a_full_stick_is_refused_before_anything_is_written(
    tmp_path, exporter, sticks, monkeypatch
):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    real = os.statvfs(str(stick))
    full = os.statvfs_result((*real[:4], 1, *real[5:]))
    monkeypatch.setattr(os, "statvfs", lambda _path: full)
    with raises_fault(faults.STICK_FULL, stick.name, error=ExportFailedError):
        exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), Cancellation())
    assert files_of(stick) == []


def test_a_stick_that_is_removed_leaves_no_file_on_the_disk_below(
    tmp_path, exporter, sticks, monkeypatch
):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    real = stick_files.copy_file

    def copy(source, target):
        real(source, target)
        sticks.pull_out()

    monkeypatch.setattr(stick_files, "copy_file", copy)
    with raises_fault(faults.STICK_GONE, stick):
        exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), Cancellation())
    assert files_of(stick) == []


def test_what_an_interrupted_export_left_is_removed(tmp_path, exporter, sticks):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    (stick / FOLDER).mkdir()
    (stick / FOLDER / ".old_survey.zip.0011aabb.tmp").write_text("half")
    exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), Cancellation())
    assert len(files_of(stick)) == 2


def test_a_survey_that_changes_meanwhile_is_refused(tmp_path, exporter, sticks, monkeypatch):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    real = stick_files.SummedFile.write

    def write(self, data):
        (folder / "survey.json").write_text("{}")
        return real(self, data)

    monkeypatch.setattr(stick_files.SummedFile, "write", write)
    with raises_fault(faults.SURVEY_CHANGES, error=ExportFailedError):
        exporter.export(request_for(folder, stick, ExportKind.SURVEY_ZIP), Cancellation())
    assert files_of(stick) == []


def test_a_refusal_of_the_analysis_is_passed_on(tmp_path, exporter, sticks, analysis):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    analysis.mode = "refuse"
    with raises_fault("test.refused"):
        exporter.export(request_for(folder, stick, ExportKind.REPORT_PDF), Cancellation())
    assert files_of(stick) == []


def test_a_cancelled_export_leaves_nothing(tmp_path, exporter, sticks, monkeypatch):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    cancellation = Cancellation()
    real = stick_files.SummedFile.write

    def write(self, data):
        cancellation.cancel()
        return real(self, data)

    monkeypatch.setattr(stick_files.SummedFile, "write", write)
    with pytest.raises(CancelledError):
        exporter.export(request_for(folder, stick, ExportKind.SURVEY_ZIP), cancellation)
    assert files_of(stick) == []


def test_cancelling_ends_the_analysis(tmp_path, exporter, sticks, analysis):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    analysis.mode = "hang"
    cancellation = Cancellation()
    seen = threading.Event()

    def cancel_when_started():
        while not seen.wait(0.02):
            if analysis.started.exists() and analysis.started.read_text():
                cancellation.cancel()
                return

    watcher = threading.Thread(target=cancel_when_started)
    watcher.start()
    with pytest.raises(CancelledError):
        exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), cancellation)
    seen.set()
    watcher.join()
    assert files_of(stick) == []
