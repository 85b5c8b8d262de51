"""Damaged input is refused by name, or left out and marked: never part of a picture unnoticed."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from survey_kit import POINTS, make_survey, write_trace_file

from gpr20_analysis import faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.sources import read_trace
from gpr20_survey.faults import TRACE_DAMAGED

ALL = len(POINTS)
VICTIM = 4
OTHER_SURVEY = "11111111-2222-3333-4444-555555555555"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture
def folder(whole, tmp_path):
    return shutil.copytree(str(whole), str(tmp_path / "survey")) and tmp_path / "survey"


def trace_file(folder, index):
    return next((folder / "traces").glob(f"{index:06d}_*"))


def change(folder, index, **entries):
    path = trace_file(folder, index)
    values = json.loads(path.read_text())
    write_trace_file(path, {**values, **entries})


def truncate(folder):
    path = trace_file(folder, VICTIM)
    path.write_bytes(path.read_bytes()[:-9])


def put_nan(folder):
    path = trace_file(folder, VICTIM)
    values = json.loads(path.read_text())
    values["s21_real"][2] = float("nan")
    write_trace_file(path, values)


def empty(folder):
    trace_file(folder, VICTIM).write_bytes(b"")


def other_frequencies(folder):
    change(folder, VICTIM, frequency_hz=np.linspace(1e9, 6e9, 5).tolist())


def fewer_points(folder):
    change(folder, VICTIM, frequency_hz=[6e8, 6e9], s21_real=[0.0, 1.0], s21_imag=[0.0, 1.0])


def elsewhere(folder):
    path = trace_file(folder, VICTIM)
    change(folder, VICTIM, x_coord_mm=11.0)
    path.rename(
        path.with_name(
            path.name.replace("X0015.00", "X0011.00")
            .replace("X0020.00", "X0011.00")
            .replace("X0010.00", "X0011.00")
        )
    )


def renamed(folder):
    first, second = trace_file(folder, VICTIM), trace_file(folder, VICTIM + 1)
    content = first.read_bytes()
    first.write_bytes(second.read_bytes())
    second.write_bytes(content)


def of_another_survey(folder):
    change(folder, VICTIM, survey_id=OTHER_SURVEY)


DAMAGES = [
    truncate, put_nan, empty, other_frequencies, fewer_points, elsewhere, renamed,
    of_another_survey,
]  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda one: one.__name__)
def test_a_damaged_file_is_refused_by_name_and_marked_once_accepted(folder, whole, damage):
    damage(folder)
    # Files alone do not tell which places were planned.
    parts = (folder,) if damage is elsewhere else (folder, folder / "traces")
    for part in parts:
        with raises_fault(faults.SURVEY_DAMAGED) as caught:
            load_survey(part)
        assert re.search(rf"\b{VICTIM}\b|{VICTIM:06d}_", str(caught.value))
    survey, good = load_survey(folder, accept_damaged=True), load_survey(whole)
    spoilt = np.isin(good["index"].values, [VICTIM, VICTIM + 1] if damage is renamed else [VICTIM])
    unusable = int(Quality.DAMAGED | Quality.MISSING)
    assert ((survey.quality.values & unusable) != 0).tolist() == spoilt.tolist()
    assert np.isnan(survey.s21.values[spoilt]).all()
    np.testing.assert_array_equal(survey.s21.values[~spoilt], good.s21.values[~spoilt])
    assert survey.attrs["faults"] and len(survey.attrs["missing"]) == spoilt.sum()


def test_one_trace_twice_is_refused_in_files_alone_and_in_their_survey(folder):
    copy = json.loads(trace_file(folder, VICTIM).read_text())
    copy["s21_real"][0] += 1e-9
    # Another place, so that the name differs.
    copy["z_coord_deg"] += 1.8
    name = trace_file(folder, VICTIM).name
    turned = f"{copy['z_coord_deg']:+07.2f}"
    path = folder / "traces" / f"{name.rsplit('_Z', 1)[0]}_Z{turned}.json"
    write_trace_file(path, copy)
    for part in (folder / "traces", folder):
        with raises_fault(faults.SURVEY_DAMAGED):
            load_survey(part)


def test_two_samples_of_one_place_are_refused(folder):
    point, other = POINTS[VICTIM], POINTS[VICTIM + 1]
    path = trace_file(folder, VICTIM + 1)
    change(folder, VICTIM + 1, x_coord_mm=point.x_mm, y_coord_mm=point.y_mm,
           z_coord_deg=point.z_deg)  # fmt: skip
    name = trace_file(folder, VICTIM).name.replace(f"{VICTIM:06d}", f"{VICTIM + 1:06d}")
    path.rename(path.with_name(name))
    assert other.index == VICTIM + 1
    with raises_fault(faults.SURVEY_DAMAGED):
        load_survey(folder / "traces")
    survey = load_survey(folder / "traces", accept_damaged=True)
    assert not np.isin(survey["index"].values, [VICTIM, VICTIM + 1]).any()


def test_half_of_the_traces_with_other_frequencies_are_refused_whatever_is_accepted(folder):
    for index in range(1, ALL):
        change(folder, index, frequency_hz=np.linspace(1e9, 6e9, 5).tolist())
    with raises_fault(faults.SURVEY_DAMAGED):
        load_survey(folder, accept_damaged=True)


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


def test_samples_with_the_same_numbers_are_noted(tmp_path):
    same = {"s21_real": np.arange(5.0), "s21_imag": np.ones(5)}
    folder = make_survey(tmp_path, ALL, "finished", {3: same, 8: same})
    notes = load_survey(folder).attrs["notes"]
    assert any("exactly the values of another" in note for note in notes)


def test_a_description_that_is_damaged_in_every_form_is_refused(folder, whole):
    good = load_survey(whole)
    for name in ("log.jsonl", "survey.json", "survey.mcap"):
        content = (folder / name).read_bytes()
        (folder / name).write_bytes(b"{")
        xr.testing.assert_identical(load_survey(folder), good.assign_attrs(source=folder.name))
        (folder / name).write_bytes(content)
    for name in ("log.jsonl", "survey.json", "survey.mcap"):
        (folder / name).write_text("{")
    with raises_fault(faults.SURVEY_DAMAGED):
        load_survey(folder)


def test_positions_on_no_grid_are_refused(folder):
    for index in range(ALL):
        path = trace_file(folder, index)
        values = json.loads(path.read_text())
        values["x_coord_mm"], values["y_coord_mm"] = 10.0 + index**1.5, 10.0 + 3 * index**1.2
        path.unlink()
        x_mm, y_mm = round(values["x_coord_mm"], 2), round(values["y_coord_mm"], 2)
        values.update(x_coord_mm=x_mm, y_coord_mm=y_mm)
        name = f"{index:06d}_X{x_mm:07.2f}_Y{y_mm:07.2f}_Z{values['z_coord_deg']:+07.2f}.json"
        write_trace_file(folder / "traces" / name, values)
    with raises_fault(faults.NO_GRID):
        load_survey(folder / "traces")


def test_a_file_that_is_not_json_is_a_damaged_trace(folder):
    truncate(folder)
    with raises_fault(TRACE_DAMAGED):
        read_trace(trace_file(folder, VICTIM))
