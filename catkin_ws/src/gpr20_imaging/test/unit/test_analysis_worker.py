"""The worker gives what the analysis gives, and its reasons, from its own process."""

from __future__ import annotations

import numpy as np
import pytest
from fault_kit import raises_fault
from pytest import approx

import gpr20_analysis
from gpr20_analysis import faults
from gpr20_analysis.sample.sample_survey import sample_survey
from gpr20_common.faults import NOT_ALLOWED
from gpr20_imaging.low.analysis_process import AnalysisProcess
from gpr20_imaging.low.cancellation import Cancellation
from gpr20_survey.results.hidden_target import Targets

PERMITTIVITY = 5.0


@pytest.fixture
def process():
    made = AnalysisProcess()
    yield made
    made.close()


def test_candidates_and_files_are_those_of_the_analysis(process, tmp_path):
    survey = sample_survey()
    found, remarks = process.find_candidates(survey, PERMITTIVITY, "en", Cancellation())
    cleaned = gpr20_analysis.process_survey(
        gpr20_analysis.load_survey(survey), "background:method=surface"
    )
    image = gpr20_analysis.image_survey(
        cleaned, gpr20_analysis.ImageOptions(permittivity=PERMITTIVITY)
    )
    here = gpr20_analysis.find_candidates(image)
    # Sums of several threads differ in their last bits.
    assert [one.id for one in found.candidates] == [one.id for one in here.candidates]
    for one, same in zip(found.candidates, here.candidates):
        assert (one.x_m, one.y_m, one.depth_m) == approx(
            (same.x_m, same.y_m, same.depth_m), abs=1e-6
        )
    assert remarks == ""
    table, report = tmp_path / "list.csv", tmp_path / "report.html"
    process.write("candidates", survey, table, PERMITTIVITY, "es", Cancellation())
    process.write("report", survey, report, PERMITTIVITY, "es", Cancellation())
    assert found.candidates[0].id in table.read_text()
    assert '<html lang="es">' in report.read_text()


def test_where_a_mine_could_hide_is_that_of_the_analysis(process, tmp_path):
    corner = gpr20_analysis.load_survey(sample_survey()).isel(x=slice(6), y=slice(6))
    file = tmp_path / "corner.nc"
    gpr20_analysis.write_dataset(corner, file)
    found = process.map_hidden(file, PERMITTIVITY, "pmn", Cancellation())
    here = gpr20_analysis.map_hidden_in_field(corner, PERMITTIVITY, Targets.PMN.value)
    assert found.target == Targets.PMN.value and found.tried.sum() > 0
    assert (found.tried == here.tried).all() and (found.found == here.found).all()
    with raises_fault(NOT_ALLOWED, "tank"):
        process.map_hidden(file, PERMITTIVITY, "tank", Cancellation())


def test_a_reason_comes_with_its_fault(process, tmp_path):
    with raises_fault(faults.NO_INPUT, tmp_path / "nowhere"):
        process.find_candidates(tmp_path / "nowhere", None, "en", Cancellation())
    with raises_fault(faults.NO_TRACES):
        folder = tmp_path / "20260921T141320_0f8fad5b"
        (folder / "traces").mkdir(parents=True)
        (folder / "survey.json").write_text("{}")
        process.focus(folder, np.float64(4.0), Cancellation())
