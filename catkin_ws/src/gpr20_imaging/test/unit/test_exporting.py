import errno
import hashlib
import os
import subprocess
import threading
import zipfile

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from imaging_kit import store_survey

from gpr20_common.faults import NOT_ALLOWED
from gpr20_imaging import faults
from gpr20_imaging.errors import CancelledError, ExportFailedError, ImagingError
from gpr20_imaging.low import stick_files
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_imaging.mid.export_kind import ExportKind
from gpr20_imaging.mid.exporting import FOLDER, Exporter, ExportRequest
from gpr20_survey.faults import NOT_A_FILE


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
    assert len(stages) == 2 * len(names) + 1  # and what was stored is read


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


@pytest.mark.parametrize("kind", [one for one in ExportKind if one.analysis])
def test_without_a_stick_the_file_is_in_the_answer(tmp_path, exporter, sticks, kind):
    folder = store_survey(tmp_path / "data")
    name, content = exporter.make(request_for(folder, "", kind), Cancellation())
    assert name == f"{folder.name}_SIMULATED_{kind.ending}"
    assert content.decode().startswith(f"{folder} 4.0 es")


@pytest.mark.parametrize(
    "kinds",
    [(ExportKind.SURVEY_ZIP,), (ExportKind.REPORT_PDF, ExportKind.REPORT_HTML)],
    ids=["whole survey", "two files"],
)
def test_without_a_stick_it_is_one_file_that_the_analysis_makes(tmp_path, exporter, kinds):
    folder = store_survey(tmp_path / "data")
    with raises_fault(NOT_ALLOWED, error=ImagingError):
        exporter.make(request_for(folder, "", *kinds), Cancellation())


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
    for kind in ExportKind:
        for name in (
            f"20260921T141320_0f8fad5b_{kind.ending}",
            f"{folder.name}_SIMULATED_report.html",
        ):
            for ending in ("", ".sha256"):
                (stick / FOLDER / f".{name}{ending}.0011aabb.tmp").write_text("half")
    exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), Cancellation())
    assert len(files_of(stick)) == 2


def test_what_another_program_left_unfinished_is_not_removed(tmp_path, exporter, sticks):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    own = ".20260921T141320_0f8fad5b_report.html"
    foreign = [
        ".letter.odt.tmp",
        ".old_survey.zip.0011aabb.tmp",
        f"{own}.tmp",
        f"{own}.0011AABB.tmp",
    ]
    foreign += [f"{own[1:]}.0011aabb.tmp", ".x_report.html.0011aabb.tmp"]
    (stick / FOLDER / f"{own}.0011aabb.tmp").mkdir(parents=True)
    for name in foreign:
        (stick / FOLDER / name).write_text("of others")
    exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), Cancellation())
    assert {*foreign, f"{own}.0011aabb.tmp"} < set(files_of(stick))


def contents(folder):
    return {one: one.read_bytes() for one in folder.rglob("*") if one.is_file()}


def put_link(path, computer):
    path.symlink_to(computer)


def put_relative_link(path, computer):
    path.symlink_to(os.path.relpath(str(computer), str(path.parent)))


def put_link_to_nothing(path, computer):
    path.symlink_to(computer / "nothing")


def put_file(path, _computer):
    path.write_text("a file")


def put_pipe(path, _computer):
    os.mkfifo(str(path))


@each_case("put", [put_link, put_relative_link, put_link_to_nothing, put_file, put_pipe])
def test_a_folder_of_exports_that_is_none_of_the_stick_is_refused(tmp_path, exporter, sticks, put):
    folder, stick = store_survey(tmp_path / put.__name__), sticks.plug_in(put.__name__)
    computer = tmp_path / f"computer_{put.__name__}"
    computer.mkdir()
    own = f".{folder.name}_SIMULATED_report.html.0011aabb.tmp"
    for name in (".letter.odt.tmp", own, f"{folder.name}_SIMULATED_report.html"):
        (computer / name).write_text("of the computer")
    before = contents(computer)
    put(stick / FOLDER, computer)
    with raises_fault(faults.STICK_FOLDER, stick.name, error=ExportFailedError):
        exporter.export(request_for(folder, stick, *ExportKind), Cancellation())
    assert contents(computer) == before
    assert [one.name for one in stick.iterdir()] == [FOLDER]


@pytest.mark.needs("mounts")
def test_another_disk_below_the_mount_point_is_refused(tmp_path, exporter, sticks):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    (stick / FOLDER).mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(stick / FOLDER)], check=True)
    try:
        with raises_fault(faults.STICK_FOLDER, stick.name, error=ExportFailedError):
            exporter.export(request_for(folder, stick, *ExportKind), Cancellation())
        assert files_of(stick) == []
    finally:
        subprocess.run(["umount", "--lazy", str(stick / FOLDER)], check=True)


def test_links_with_the_names_of_exports_are_replaced_not_followed(tmp_path, exporter, sticks):
    folder, stick = store_survey(tmp_path / "data"), sticks.plug_in()
    (stick / FOLDER).mkdir()
    target = tmp_path / "computer"
    target.write_text("of the computer")
    wanted = request_for(folder, stick, *ExportKind)
    for kind in ExportKind:
        for ending in ("", ".sha256"):
            (stick / FOLDER / (wanted.name(kind) + ending)).symlink_to(target)
    for name in exporter.export(wanted, Cancellation()):
        assert not (stick / name).is_symlink() and not (stick / f"{name}.sha256").is_symlink()
    assert target.read_text() == "of the computer"


@each_case("level", ["the folder of the exports", "the mount point"])
def test_a_link_that_is_put_there_meanwhile_leads_nowhere(
    tmp_path, exporter, sticks, monkeypatch, level
):
    folder, stick = store_survey(tmp_path / level[-5:] / "data"), sticks.plug_in(level[-5:])
    computer = tmp_path / level[-5:] / "computer"
    (computer / FOLDER).mkdir(parents=True)
    real = stick_files.copy_file

    def copy(source, target):
        moved = stick if level == "the mount point" else stick / FOLDER
        if not moved.is_symlink():
            moved.rename(moved.with_name("moved"))
            moved.symlink_to(computer if moved is stick else computer / FOLDER)
        real(source, target)

    monkeypatch.setattr(stick_files, "copy_file", copy)
    with pytest.raises(ImagingError):
        exporter.export(request_for(folder, stick, ExportKind.REPORT_HTML), Cancellation())
    assert contents(computer) == {}
    monkeypatch.setattr(stick_files, "copy_file", real)


def cut_off(path):
    os.truncate(str(path), 3)


def change_a_byte(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


@each_case("spoil", [cut_off, change_a_byte, os.unlink])
@each_case("ending", ["", ".sha256"])
def test_what_is_not_on_the_stick_after_all_is_no_success(
    tmp_path, exporter, sticks, monkeypatch, spoil, ending
):
    folder, stick = store_survey(tmp_path / f"{spoil.__name__}{ending}"), sticks.plug_in()
    wanted = request_for(folder, stick, ExportKind.SURVEY_ZIP)
    path = stick / FOLDER / (wanted.name(ExportKind.SURVEY_ZIP) + ending)
    with monkeypatch.context() as patched:
        patched.setattr(stick_files.StickFolder, "sync", lambda _self: spoil(path))
        with raises_fault(faults.STICK_FAILED, stick.name, error=ExportFailedError):
            exporter.export(wanted, Cancellation())


@each_case("put", [put_link, put_pipe])
def test_a_survey_that_cannot_be_read_is_no_fault_of_the_stick(tmp_path, exporter, sticks, put):
    folder, stick = store_survey(tmp_path / put.__name__), sticks.plug_in()
    (tmp_path / f"file_{put.__name__}").write_text("elsewhere")
    put(folder / "survey.bag", tmp_path / f"file_{put.__name__}")
    with raises_fault(NOT_A_FILE, "survey.bag", error=ImagingError):
        exporter.export(request_for(folder, stick, ExportKind.SURVEY_ZIP), Cancellation())
    assert files_of(stick) == []


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
