"""NetCDF files keep the conventions; no text in a CSV file is a formula."""

import csv
import io
import math
import os
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from candidate_examples import candidate_list
from case_kit import each_case
from hypothesis import example, given
from hypothesis import strategies as st
from random_surveys import random_survey
from survey_kit import POINTS, make_survey

from gpr20_analysis import (
    cell_text,
    export_survey,
    load_survey,
    write_candidates,
    write_markers,
)
from gpr20_analysis.candidates.table import MarkerList
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.dataset_files import csv_cell, write_dataset
from gpr20_common.message import verbatim
from gpr20_survey.plan.markers import Marker
from gpr20_survey.results.candidates import Candidate

CHECKER = Path(sys.executable).parent / "compliance-checker"
IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return a file of each kind: survey, A-scans, image, survey with holes."""
    folder = tmp_path_factory.mktemp("files")
    survey = make_survey(folder, len(POINTS) - 3, "stopped")
    paths = [folder / name for name in ("survey.nc", "time.nc", "image.nc", "holes.nc")]
    main(["export", str(survey), str(paths[0]), "--format", "netcdf"])
    main(["process", str(survey), "--step", "time", "-o", str(paths[1])])
    arguments = [*IMAGE, "--leave-out-missing", "-o", str(paths[2])]
    main(["image", str(survey), *arguments])
    write_dataset(random_survey(5), paths[3])
    return paths


@pytest.mark.skipif(
    sys.version_info < (3, 9), reason="its versions for Python 3.8 do not know CF 1.9"
)
def test_the_cf_checker_finds_nothing(files):
    # A process of its own: its NetCDF library and h5py bring different HDF5 libraries.
    command = [str(CHECKER), "--test=cf:1.9", "--criteria=strict", *map(str, files)]
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run(command, check=False, stdout=subprocess.PIPE, env=environment)
    assert done.returncode == 0, done.stdout.decode()


def test_xarray_reads_numbers_flags_and_times(tmp_path):
    survey = random_survey(3).assign_attrs(simulated=1)
    survey.timestamp.values[:] = np.datetime64("2026-03-05T14:07:09.123456", "ns")
    write_dataset(survey, tmp_path / "s.nc")
    with xr.open_dataset(tmp_path / "s.nc", engine="h5netcdf") as found:
        own = found.s21_real.values + 1j * found.s21_imag.values
        np.testing.assert_array_equal(own, survey.s21.values)
        np.testing.assert_array_equal(found.timestamp.values, survey.timestamp.values)
        assert found.x.attrs["units"] == found.height.attrs["units"] == "m"
        flags = found.quality.attrs
        masks = dict(zip(flags["flag_meanings"].split(), flags["flag_masks"].tolist()))
        assert masks["missing"] == int(Quality.MISSING)
        assert "SIMULATED" in found.attrs["title"]
        assert survey.attrs["survey_id"] in found.attrs["title"]


def test_h5py_reads_an_export_as_hdf5(tmp_path):
    survey = random_survey(4)
    export_survey(survey, tmp_path / "s.nc", "netcdf")
    with h5py.File(tmp_path / "s.nc") as file:
        own = file["s21_real"][:] + 1j * file["s21_imag"][:]
        np.testing.assert_array_equal(own, survey.s21.values)
        np.testing.assert_array_equal(file["frequency"][:], survey.frequency.values)
        assert file["s21_real"].fletcher32 and file["height"].fletcher32


SEPARATORS = (",", ";", "\t")
FORMULA = tuple("=+-@\t\r\n\uff1d\uff0b\uff0d\uff20")
TEXTS = st.lists(
    st.one_of(
        st.sampled_from(
            [*FORMULA, *SEPARATORS, "'", '"', " ", "\u00a0", "cmd", "1", "HYPERLINK()"]
        ),
        st.text(max_size=3),
    ),
    max_size=8,
).map("".join)


def is_number(cell):
    try:
        return math.isfinite(float(cell)) and "_" not in cell
    except ValueError:
        return False


def live_cells(text):
    """Return the cells of a file that a spreadsheet may take for a formula."""
    found = []
    for separator in SEPARATORS:
        for quoting in (csv.QUOTE_MINIMAL, csv.QUOTE_NONE):
            lines = io.StringIO(text, newline="")
            for row in csv.reader(lines, delimiter=separator, quoting=quoting):
                cells = (one.lstrip(' "\u00a0') for one in row)
                found += [one for one in cells if one.startswith(FORMULA) and not is_number(one)]
    return found


def as_file(*cells):
    stream = io.StringIO(newline="")
    csv.writer(stream).writerow(cells)
    return stream.getvalue()


@given(TEXTS)
@example("'=1")
@example("''-5")
@example("x;=1+1")
@example('x;"=1+1"')
@example("-90 -45")
def test_a_text_is_no_formula_and_is_read_back(text):
    cell = csv_cell(text)
    assert cell_text(cell) == text
    # The writer ends a line by itself, so only what is in a line may begin like that.
    assert not live_cells(as_file("id", cell, "end")), repr(cell)
    assert not live_cells(as_file(cell)), repr(cell)


@each_case("value", [0, -1.5, 1e-300, -12, "-90", "+5.25", "0.1", "plain, text; with 3 - 1", ""])
def test_numbers_and_plain_texts_stay(value):
    assert csv_cell(value) == value
    assert csv_cell(None) == ""


def test_files_of_markers_of_candidates_and_of_samples_hold_no_formula(tmp_path):
    marked, found, table = (tmp_path / name for name in ("m.csv", "c.csv", "s.csv"))
    hostile = '";=cmd|,=1'
    marker = Marker("7c9e6679-7425-40de-944b-e07fc1f90ae7", -12.5, 20.0, 80.0, hostile, "=1")
    write_markers(MarkerList("@1", True, (marker,)), marked)
    one = Candidate("C01", -0.1, 0.2, 0.1, 0.0, 0.0, 0.0, 20.0, (-90.0, -45.0), -0.1, ())
    listed = candidate_list([one], survey_id="@1", method="+1", notes=(verbatim(hostile),))
    write_candidates(listed, found)
    survey = load_survey(make_survey(tmp_path, len(POINTS), "finished"))
    survey["aux_soil"] = survey["height"].assign_attrs(units=f"{hostile}\n=1")
    export_survey(survey, table, "csv")
    rows = {}
    for path in (marked, found, table):
        with path.open(encoding="utf-8", newline="") as stream:
            text = stream.read()
        assert not live_cells(text), path
        rows[path] = list(map(cell_text, list(csv.reader(io.StringIO(text, newline="")))[-1]))
    assert {hostile, "=1", "-0.0125"} <= set(rows[marked])
    assert {"-90 -45", "-0.1"} <= set(rows[found])
