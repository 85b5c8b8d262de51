"""Others read what is exported; it says that it is simulated."""

import json

import numpy as np
import pandas as pd
import pytest
import segyio
import skrf
from fault_kit import raises_fault
from obspy.io.segy.segy import _read_segy
from random_surveys import random_survey
from run_seed import draws
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import usable
from gpr20_analysis.formats.exports import export_survey
from gpr20_analysis.formats.facts import facts_beside, with_facts
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sentences import with_doubts
from gpr20_common.message import Message
from gpr20_survey.radar.frequency_to_delay import Window

ALL = len(POINTS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("whole")
    return make_survey(place, ALL, "finished", more={"simulated": True})


@pytest.fixture(scope="module")
def survey(folder):
    return load_survey(folder)


def export(source, output, kind, *more):
    return main(["export", str(source), str(output), "--format", kind, *more])


def test_scikit_rf_reads_s21_from_touchstone(survey, folder, tmp_path):
    assert export(folder, tmp_path / "ts", "touchstone") == 0
    files = sorted((tmp_path / "ts").glob("*.s2p"))
    assert len(files) == ALL
    network = skrf.Network(str(files[0]))
    own = survey.s21.values[survey["index"].values == 0][0]
    np.testing.assert_allclose(network.s[:, 1, 0], own, rtol=1e-12)
    np.testing.assert_allclose(network.f, survey.frequency.values, rtol=1e-12)
    assert "only S21 was measured" in files[0].read_text()


def test_pandas_reads_the_plain_table(survey, folder, tmp_path):
    assert export(folder, tmp_path / "t.csv", "csv") == 0
    table = pd.read_csv(tmp_path / "t.csv", float_precision="round_trip")
    row = table[table["index"] == 7].iloc[0]
    own = survey.s21.values[survey["index"].values == 7][0]
    assert row["real_600000000.0_hz"] == own[0].real
    assert row["imag_6000000000.0_hz"] == own[-1].imag


def test_what_a_format_has_no_place_for_is_beside_it_as_json(tmp_path):
    survey = random_survey(1, one_polarization=True)
    survey = survey.assign_attrs(operator="Ana", notes=["measured twice"])
    survey = with_doubts(survey, Message("levels may be wrong").with_fault(faults.CALIBRATION))
    bare = survey.assign_attrs(operator="", notes=[], doubts=[])
    for form, name in (("touchstone", "out"), ("csv", "out.csv"), ("segy", "out.sgy")):
        for path in export_survey(survey, tmp_path / name, form):
            facts = json.loads((tmp_path / f"{path.name}.json").read_text())
            assert (facts["survey_id"], facts["operator"]) == ("survey-1", "Ana"), form
            found = with_facts(bare, facts_beside(path))
            assert found.attrs["doubts"] == ["levels may be wrong"]
            assert found.attrs["operator"] == "Ana"
            assert "measured twice" in found.attrs["notes"]


SEEDS = range(draws(2))
WITHIN_M = 0.51e-4
MOMENT = np.datetime64("2026-03-05T14:07:09", "ns")


def scaled(value, scalar):
    return value * scalar if scalar > 0 else value / -scalar


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return random surveys, each with the SEG-Y files of its polarizations."""
    made = []
    for seed in SEEDS:
        survey = random_survey(seed)
        survey.timestamp.values[:] = MOMENT
        path = tmp_path_factory.mktemp("segy") / "s.sgy"
        made.append((survey, list(export_survey(survey, path, "segy"))))
    return made


def test_obspy_reads_counts_units_places_and_heights(written):
    files = [(one, *file) for one, paths in written for file in enumerate(paths)]
    for survey, turn, path in files:
        file = _read_segy(str(path))
        binary = file.binary_file_header
        present = usable(survey).values[turn]
        rows, columns = present.shape
        assert len(file.traces) == rows * columns
        assert binary.seg_y_format_revision_number == 0x0100
        assert (binary.data_sample_format_code, binary.measurement_system) == (5, 1)
        assert binary.sample_interval_in_microseconds == 50
        for number, trace in enumerate(file.traces):
            header, (row, column) = trace.header, divmod(number, columns)
            assert len(trace.data) == binary.number_of_samples_per_data_trace
            assert header.coordinate_units == 1
            assert header.trace_sequence_number_within_segy_file == number + 1
            assert header.for_3d_poststack_data_this_field_is_for_in_line_number == row + 1
            assert header.for_3d_poststack_data_this_field_is_for_cross_line_number == column + 1
            scalar = header.scalar_to_be_applied_to_all_coordinates
            for place in ("source_coordinate", "group_coordinate"):
                x_m = scaled(getattr(header, f"{place}_x"), scalar)
                y_m = scaled(getattr(header, f"{place}_y"), scalar)
                assert x_m == pytest.approx(float(survey.x[column]), abs=WITHIN_M)
                assert y_m == pytest.approx(float(survey.y[row]), abs=WITHIN_M)
            height_m = scaled(
                header.receiver_group_elevation,
                header.scalar_to_be_applied_to_all_elevations_and_depths,
            )
            true_m = np.nan_to_num(float(survey.height[turn, row, column]))
            assert height_m == pytest.approx(true_m, abs=WITHIN_M)
            live = header.trace_identification_code == 1
            assert live == present[row, column] == bool(np.any(trace.data))
            assert (header.year_data_recorded, header.day_of_year) == (2026, 64)
            assert (header.hour_of_day, header.time_basis_code) == (14, 4)


def test_segyio_and_obspy_read_the_same_numbers(written):
    for path in (path for _, paths in written for path in paths):
        with segyio.open(str(path), strict=True) as file:
            own = file.trace.raw[:]
            assert list(file.samples) == pytest.approx(0.05 * np.arange(own.shape[1]))
            assert segyio.tools.cube(file).shape[:2] == (len(file.ilines), len(file.xlines))
        others = np.stack([trace.data for trace in _read_segy(str(path)).traces])
        np.testing.assert_array_equal(own, others)


def test_the_textual_header_says_what_the_numbers_mean(written):
    for survey, path in ((one, path) for one, paths in written for path in paths):
        text = path.read_bytes()[:3200].decode("cp500")
        lines = [text[start : start + 80] for start in range(0, 3200, 80)]
        assert all(line.startswith(f"C{number:2d} ") for number, line in enumerate(lines, 1))
        assert f"SURVEY {survey.attrs['survey_id']}" in lines[0]
        assert ("SIMULATED" in text) is bool(survey.attrs["simulated"])
        assert "1 MICROSECOND IN THIS FILE MEANS 1 PICOSECOND" in text


def test_a_scans_over_time_are_written_unchanged(tmp_path):
    survey = random_survey(7, one_polarization=True)
    step_s = 100e-12
    survey = survey.isel(frequency=slice(0, 3))
    survey = survey.assign_coords(frequency=1e9 + np.arange(3) / (3 * step_s))
    in_time = to_time(survey, Window.NONE, 1.0)
    (path,) = export_survey(in_time, tmp_path / "s.sgy", "segy")
    found = np.stack([trace.data for trace in _read_segy(str(path)).traces])
    own = np.nan_to_num(in_time.a_scan.values.real.astype(np.float32)).reshape(found.shape)
    np.testing.assert_array_equal(found, own)


def test_positions_that_do_not_fit_are_refused_before_anything_is_written(tmp_path):
    survey = random_survey(1, one_polarization=True)
    far = survey.assign_coords(y=survey.y - 5e6)
    with raises_fault(faults.INPUT, "y", "200000 m"):
        export_survey(far, tmp_path / "far.sgy", "segy")
    assert not list(tmp_path.iterdir())
