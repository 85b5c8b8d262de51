"""Exports for other programs are replaced only when that is asked for, and never a survey."""

from __future__ import annotations

import pytest
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.commands.main import main

ALL = len(POINTS)
OUTPUTS = {
    "merged-hdf5": ("o.h5", ""),
    "group-csv": ("group", "VNA_X1_Y1.csv"),
    "original-json": ("original", "X1_Y1_Z1.json"),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.mark.parametrize("form", OUTPUTS)
def test_what_exists_is_refused_then_replaced_when_that_is_asked_for(
    folder, tmp_path, refusals, form
):
    name, inside = OUTPUTS[form]
    precious = tmp_path / name / inside
    precious.parent.mkdir(exist_ok=True)
    precious.write_text("precious")
    arguments = ["export", str(folder), str(tmp_path / name), "--format", form]
    assert main(arguments) == 3
    assert refusals == [faults.OUTPUT.code]
    assert precious.read_text() == "precious"
    assert main([*arguments, "--overwrite"]) == 0
    assert not precious.exists() or precious.read_bytes() != b"precious"


def test_traces_of_a_survey_are_no_output_that_may_be_replaced(folder, refusals):
    arguments = ["export", str(folder), str(folder / "traces"), "--format", "original-json"]
    assert main([*arguments, "--overwrite"]) == 3
    assert refusals == [faults.OUTPUT.code]
    assert len(list((folder / "traces").iterdir())) == ALL
