"""Every command, every kind of input, every damage: refused, or reported by the exit status."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.read.load import load_survey

pytestmark = pytest.mark.usefixtures("blank_figures")

ALL = len(POINTS)
VICTIM = 7
DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")
COMMANDS = {
    "info": ("info", "SURVEY"),
    "process": ("process", "SURVEY", "--step", "background", "-o", "OUT.nc"),
    "image": ("image", "SURVEY", *IMAGE, "--leave-out-missing", "-o", "OUT.nc"),
    "candidates": ("candidates", "SURVEY", *IMAGE, "--leave-out-missing", "-o", "OUT.csv"),
    "plot": ("plot", "coverage", "SURVEY", "-o", "OUT.png"),
    "export": ("export", "SURVEY", "OUT.csv", "--format", "csv"),
    "report": ("report", "SURVEY", *IMAGE, "-o", "OUT.html"),
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture(scope="module")
def cut_short(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("short"), ALL - 2, "stopped")


@pytest.fixture
def folder(whole, tmp_path):
    shutil.copytree(str(whole), str(tmp_path / "survey"))
    return tmp_path / "survey"


def trace_file(folder, index=VICTIM):
    return next((folder / "traces").glob(f"{index:06d}_*"))


def truncated(folder):
    trace_file(folder).write_bytes(trace_file(folder).read_bytes()[:-20])


def run(command, source, tmp_path, *more):
    """Return the exit status and what was written, without checksums."""
    there = Path(tempfile.mkdtemp(prefix=command, dir=str(tmp_path)))
    words = [one.replace("SURVEY", str(source)) for one in COMMANDS[command]]
    words = [one.replace("OUT", str(there / "result")) for one in words]
    status = main([*words, *more])
    return status, [path for path in there.iterdir() if path.suffix != ".sha256"]


def test_every_command_refuses_damaged_files_until_they_are_accepted(folder, tmp_path, capsys):
    truncated(folder)
    for command in COMMANDS:
        assert run(command, folder, tmp_path) == (REFUSED, []), command
        error = capsys.readouterr().err
        assert f"{VICTIM:06d}_" in error or f"trace {VICTIM}" in error, command
        assert "Traceback" not in error, command
        status, written = run(command, folder, tmp_path, "--accept-damaged")
        assert status == DAMAGED, command
        assert len(written) == (command != "info"), command
        assert "DAMAGED: " in capsys.readouterr().err, command


def test_missing_samples_are_told_by_every_command_and_for_every_kind(cut_short, tmp_path, capsys):
    def assert_told(command, source):
        status, written = run(command, source, tmp_path)
        assert status == NOT_COMPLETE, (command, source)
        assert len(written) == (command != "info"), (command, source)
        assert "NO DATA: missing: " in capsys.readouterr().err, (command, source)

    for command in COMMANDS:
        assert_told(command, cut_short)
    for kind in ("survey.bag", "survey.mcap"):
        assert_told("process", cut_short / kind)
    for kind in ("s.nc", "s.zarr"):
        write_dataset(load_survey(cut_short), tmp_path / kind)
        assert_told("process", tmp_path / kind)
    shutil.copytree(str(cut_short / "traces"), str(tmp_path / "traces"))
    trace_file(tmp_path, 3).unlink()  # nothing says that two more would have come
    for command in ("info", "process", "export"):
        assert_told(command, tmp_path / "traces")


@pytest.mark.parametrize("kind", ["survey.bag", "survey.mcap", "s.nc", "s.zarr"])
def test_a_file_cut_short_is_refused_or_told(whole, tmp_path, capsys, kind):
    victim = tmp_path / kind
    if kind.startswith("s."):
        write_dataset(load_survey(whole), victim)
    else:
        shutil.copy(str(whole / kind), str(victim))
    part = victim if victim.is_file() else next((victim / "s21_real").glob("0*"))
    part.write_bytes(part.read_bytes()[: part.stat().st_size // 2])
    for command in ("info", "process"):
        status, written = run(command, victim, tmp_path)
        assert status in (NOT_COMPLETE, REFUSED)
        assert status == NOT_COMPLETE or not written
        error = capsys.readouterr().err
        assert kind in error or "NO DATA" in error
        assert "Traceback" not in error


def test_a_dataset_in_another_order_is_refused(whole, tmp_path, refusals):
    survey = load_survey(whole)
    for order in (slice(None, None, -1), np.random.default_rng(1).permutation(5)):
        write_dataset(survey.isel(frequency=order), tmp_path / "s.nc")
        assert run("process", tmp_path / "s.nc", tmp_path) == (REFUSED, [])
        assert refusals[-1:] == [faults.FILE_DAMAGED.code]


def test_numbers_that_are_none_in_good_samples_of_a_dataset_are_refused_or_marked(
    whole, tmp_path, capsys
):
    survey = load_survey(whole)
    survey.s21[0, 1, 1, 3] = np.nan
    write_dataset(survey, tmp_path / "s.nc")
    assert run("info", tmp_path / "s.nc", tmp_path) == (REFUSED, [])
    assert "x 15 mm, y 15 mm, 0 deg" in capsys.readouterr().err
    marked = load_survey(tmp_path / "s.nc", accept_damaged=True)
    assert np.isnan(marked.s21.values[0, 1, 1]).all()
    assert len(marked.attrs["missing"]) == len(marked.attrs["faults"]) == 1


@pytest.mark.parametrize("place", np.linspace(0.05, 0.95, 10))
def test_a_changed_byte_of_what_gpr20_wrote_is_refused(whole, tmp_path, refusals, place):
    path = tmp_path / "s.nc"
    assert main(["export", str(whole), str(path), "--format", "netcdf"]) == DONE
    content = bytearray(path.read_bytes())
    content[int(len(content) * place)] ^= 0x10
    path.write_bytes(content)
    assert main(["info", str(path)]) == REFUSED
    assert refusals[-1:] == [faults.FILE_CHANGED.code]


def test_a_dataset_of_somebody_else_is_read_with_a_word_on_its_missing_checksum(whole, tmp_path):
    write_dataset(load_survey(whole), tmp_path / "s.nc")
    with xr.open_dataset(str(tmp_path / "s.nc"), engine="h5netcdf") as stored:
        stored.load().to_netcdf(str(tmp_path / "o.nc"), engine="h5netcdf")
    assert any(
        "no gpr20 checksum" in note for note in load_survey(tmp_path / "o.nc").attrs["notes"]
    )
    xr.Dataset({"rain": ("day", [1.0, 2.0])}).to_netcdf(str(tmp_path / "w.nc"), engine="h5netcdf")
    assert main(["info", str(tmp_path / "w.nc")]) == REFUSED
