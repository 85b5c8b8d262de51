"""Damaged input is refused by name, or left out and marked: never part of a picture unnoticed."""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from survey_kit import POINTS, make_survey, write_trace_file

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.sources import read_trace
from gpr20_survey.faults import TRACE_DAMAGED

pytestmark = pytest.mark.usefixtures("blank_figures")

ALL = len(POINTS)
VICTIM = 4
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


@pytest.fixture
def folder(whole, tmp_path):
    return Path(shutil.copytree(str(whole), str(tmp_path / "survey")))


def trace_file(folder, index=VICTIM):
    return next((folder / "traces").glob(f"{index:06d}_*"))


def change(folder, index=VICTIM, **entries):
    path = trace_file(folder, index)
    write_trace_file(path, {**json.loads(path.read_text()), **entries})


def truncate(folder):
    trace_file(folder).write_bytes(trace_file(folder).read_bytes()[:-20])


def elsewhere(folder):
    path = trace_file(folder)
    change(folder, x_coord_mm=11.0)
    path.rename(path.with_name(re.sub(r"X00\d\d", "X0011", path.name)))


def exchanged(folder):
    first, second = trace_file(folder), trace_file(folder, VICTIM + 1)
    content = first.read_bytes()
    first.write_bytes(second.read_bytes())
    second.write_bytes(content)


DAMAGES = {
    "truncated": truncate,
    "empty": lambda folder: trace_file(folder).write_bytes(b""),
    "not a number": lambda folder: change(folder, s21_real=[0.0, 1.0, float("nan"), 2.0, 3.0]),
    "other frequencies": lambda folder: change(
        folder, frequency_hz=np.linspace(1e9, 6e9, 5).tolist()
    ),
    "fewer points": lambda folder: change(
        folder, frequency_hz=[6e8, 6e9], s21_real=[0.0, 1.0], s21_imag=[0.0, 1.0]
    ),
    "elsewhere": elsewhere,
    "exchanged": exchanged,
    "of another survey": lambda folder: change(
        folder, survey_id="11111111-2222-3333-4444-555555555555"
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_refused_by_name_and_marked_once_accepted(folder, whole, damage):
    DAMAGES[damage](folder)
    # Files alone do not tell which places were planned.
    for part in (folder,) if damage == "elsewhere" else (folder, folder / "traces"):
        with raises_fault(faults.SURVEY_DAMAGED) as caught:
            load_survey(part)
        assert re.search(rf"\b{VICTIM}\b|{VICTIM:06d}_", str(caught.value))
    survey, good = load_survey(folder, accept_damaged=True), load_survey(whole)
    victims = [VICTIM, VICTIM + 1] if damage == "exchanged" else [VICTIM]
    spoilt = np.isin(good["index"].values, victims)
    unusable = int(Quality.DAMAGED | Quality.MISSING)
    assert ((survey.quality.values & unusable) != 0).tolist() == spoilt.tolist()
    assert np.isnan(survey.s21.values[spoilt]).all()
    np.testing.assert_array_equal(survey.s21.values[~spoilt], good.s21.values[~spoilt])
    assert survey.attrs["faults"] and len(survey.attrs["missing"]) == spoilt.sum()


def test_one_trace_or_place_twice_and_frequencies_that_no_half_shares_are_refused(folder, tmp_path):
    twice, place, halves = (
        Path(shutil.copytree(str(folder), str(tmp_path / name))) for name in "abc"
    )
    copy = json.loads(trace_file(twice).read_text())
    copy["z_coord_deg"] += 1.8
    turned = f"_Z{copy['z_coord_deg']:+07.2f}.json"
    name = trace_file(twice).name.rsplit("_Z", 1)[0]
    write_trace_file(twice / "traces" / f"{name}{turned}", copy)
    point, path = POINTS[VICTIM], trace_file(place, VICTIM + 1)
    change(place, VICTIM + 1, x_coord_mm=point.x_mm, y_coord_mm=point.y_mm, z_coord_deg=point.z_deg)
    other = trace_file(place).name.replace(f"{VICTIM:06d}", f"{VICTIM + 1:06d}")
    path.rename(path.with_name(other))
    for index in range(1, ALL):
        change(halves, index, frequency_hz=np.linspace(1e9, 6e9, 5).tolist())
    for part in (twice, twice / "traces", place / "traces"):
        with raises_fault(faults.SURVEY_DAMAGED):
            load_survey(part)
    survey = load_survey(place / "traces", accept_damaged=True)
    assert not np.isin(survey["index"].values, [VICTIM, VICTIM + 1]).any()
    with raises_fault(faults.SURVEY_DAMAGED):
        load_survey(halves, accept_damaged=True)


def test_positions_on_no_grid_are_refused_and_equal_samples_noted(folder, tmp_path):
    for index in range(ALL):
        path = trace_file(folder, index)
        values = json.loads(path.read_text())
        path.unlink()
        x_mm, y_mm = round(10.0 + index**1.5, 2), round(10.0 + 3 * index**1.2, 2)
        values.update(x_coord_mm=x_mm, y_coord_mm=y_mm)
        name = f"{index:06d}_X{x_mm:07.2f}_Y{y_mm:07.2f}_Z{values['z_coord_deg']:+07.2f}.json"
        write_trace_file(folder / "traces" / name, values)
    with raises_fault(faults.NO_GRID):
        load_survey(folder / "traces")
    same = {"s21_real": np.arange(5.0), "s21_imag": np.ones(5)}
    alike = make_survey(tmp_path / "alike", ALL, "finished", {3: same, 8: same})
    assert any("exactly the values of another" in one for one in load_survey(alike).attrs["notes"])


def test_a_truncated_or_changed_recording_never_gives_samples_that_were_not_stored(whole, tmp_path):
    good = load_survey(whole)
    bag, mcap = ((whole / name).read_bytes() for name in ("survey.bag", "survey.mcap"))

    def changed(place):
        content = bytearray(mcap)
        content[int(len(content) * place)] ^= 0x55
        return bytes(content)

    shares = (0.3, 0.6, 0.9)
    cases = [("survey.bag", bag[: int(len(bag) * share)], True) for share in shares]
    cases += [("survey.mcap", mcap[: int(len(mcap) * share)], True) for share in shares]
    cases += [("survey.mcap", changed(place), False) for place in np.linspace(0.2, 0.8, 7)]
    for name, content, cut_off in cases:
        (tmp_path / name).write_bytes(content)
        try:
            survey = load_survey(tmp_path / name, accept_damaged=True)
        except AnalysisError:
            continue
        present = survey["index"].values >= 0
        assert not cut_off or present.sum() + len(survey.attrs["missing"]) == ALL
        np.testing.assert_array_equal(survey.s21.values[present], good.s21.values[present])


def test_a_description_is_read_from_each_form_that_is_left_and_refused_without(folder, whole):
    good = load_survey(whole)
    forms = ("log.jsonl", "survey.json", "survey.mcap")
    for name in forms:
        content = (folder / name).read_bytes()
        (folder / name).write_bytes(b"{")
        xr.testing.assert_identical(load_survey(folder), good.assign_attrs(source=folder.name))
        (folder / name).write_bytes(content)
    for name in forms:
        (folder / name).write_text("{")
    with raises_fault(faults.SURVEY_DAMAGED):
        load_survey(folder)


def run(command, source, tmp_path, *more):
    """Return the exit status and what was written, without checksums."""
    there = Path(tempfile.mkdtemp(prefix=command, dir=str(tmp_path)))
    words = [one.replace("SURVEY", str(source)) for one in COMMANDS[command]]
    words = [one.replace("OUT", str(there / "result")) for one in words]
    status = main([*words, *more])
    return status, [path for path in there.iterdir() if path.suffix != ".sha256"]


def test_every_command_refuses_damaged_files_until_they_are_accepted(folder, tmp_path, capsys):
    truncate(folder)
    with raises_fault(TRACE_DAMAGED):
        read_trace(trace_file(folder))
    for command in COMMANDS:
        assert run(command, folder, tmp_path) == (REFUSED, []), command
        error = capsys.readouterr().err
        assert f"{VICTIM:06d}_" in error or f"trace {VICTIM}" in error, command
        status, written = run(command, folder, tmp_path, "--accept-damaged")
        assert status == DAMAGED, command
        assert len(written) == (command != "info"), command
        assert "DAMAGED: " in capsys.readouterr().err, command


def test_missing_samples_are_told_by_every_command_and_for_every_kind(tmp_path, capsys):
    cut_short = make_survey(tmp_path / "short", ALL - 2, "stopped")
    for kind in ("s.nc", "s.zarr"):
        write_dataset(load_survey(cut_short), tmp_path / kind)
    shutil.copytree(str(cut_short / "traces"), str(tmp_path / "traces"))
    trace_file(tmp_path, 3).unlink()  # nothing says that two more would have come
    kinds = (cut_short / "survey.bag", cut_short / "survey.mcap", tmp_path / "s.nc")
    for command, source in (
        *((command, cut_short) for command in COMMANDS),
        *(("process", one) for one in (*kinds, tmp_path / "s.zarr", tmp_path / "traces")),
    ):
        status, written = run(command, source, tmp_path)
        assert status == NOT_COMPLETE, (command, source)
        assert len(written) == (command != "info"), (command, source)
        assert "NO DATA: missing: " in capsys.readouterr().err, (command, source)


@pytest.mark.parametrize("kind", ["survey.bag", "survey.mcap", "s.nc", "s.zarr"])
def test_a_file_cut_short_is_refused_or_told(whole, tmp_path, capsys, kind):
    victim = tmp_path / kind
    if kind.startswith("s."):
        write_dataset(load_survey(whole), victim)
    else:
        shutil.copy(str(whole / kind), str(victim))
    part = victim if victim.is_file() else next((victim / "s21_real").glob("0*"))
    part.write_bytes(part.read_bytes()[: part.stat().st_size // 2])
    status, written = run("process", victim, tmp_path)
    assert status == NOT_COMPLETE or (status, written) == (REFUSED, [])
    error = capsys.readouterr().err
    assert (kind in error or "NO DATA" in error) and "Traceback" not in error


def test_a_dataset_that_was_changed_is_refused(whole, tmp_path, refusals, capsys):
    path = tmp_path / "e.nc"
    assert main(["export", str(whole), str(path), "--format", "netcdf"]) == DONE
    content = path.read_bytes()
    for place in np.linspace(0.05, 0.95, 5):
        changed = bytearray(content)
        changed[int(len(content) * place)] ^= 0x10
        path.write_bytes(changed)
        assert main(["info", str(path)]) == REFUSED
    assert refusals == [faults.FILE_CHANGED.code] * 5
    survey = load_survey(whole)
    for order in (slice(None, None, -1), np.random.default_rng(1).permutation(5)):
        write_dataset(survey.isel(frequency=order), tmp_path / "s.nc")
        assert run("process", tmp_path / "s.nc", tmp_path) == (REFUSED, [])
        assert refusals[-1:] == [faults.FILE_DAMAGED.code]
    survey.s21[0, 1, 1, 3] = np.nan
    write_dataset(survey, tmp_path / "s.nc")
    capsys.readouterr()
    assert run("info", tmp_path / "s.nc", tmp_path) == (REFUSED, [])
    assert "x 15 mm, y 15 mm, 0 deg" in capsys.readouterr().err
    marked = load_survey(tmp_path / "s.nc", accept_damaged=True)
    assert np.isnan(marked.s21.values[0, 1, 1]).all()
    assert len(marked.attrs["missing"]) == len(marked.attrs["faults"]) == 1


def test_a_dataset_of_somebody_else_is_read_with_a_word_on_its_missing_checksum(whole, tmp_path):
    write_dataset(load_survey(whole), tmp_path / "s.nc")
    with xr.open_dataset(str(tmp_path / "s.nc"), engine="h5netcdf") as stored:
        stored.load().to_netcdf(str(tmp_path / "o.nc"), engine="h5netcdf")
    notes = load_survey(tmp_path / "o.nc").attrs["notes"]
    assert any("no gpr20 checksum" in note for note in notes)
    xr.Dataset({"rain": ("day", [1.0, 2.0])}).to_netcdf(str(tmp_path / "w.nc"), engine="h5netcdf")
    assert main(["info", str(tmp_path / "w.nc")]) == REFUSED
