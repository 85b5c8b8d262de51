"""Files of other programs become surveys in the folder of the surveys."""

from __future__ import annotations

import json

import numpy as np
import pytest
from random_surveys import random_survey
from test_round_trips import FORMATS, SINGLE, same

from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.conversion import export_survey
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verification import verify_survey
from gpr20_survey.folder.survey_folder import FOLDER_NAME


def imported(path, form, data, *options):
    """Import into a folder of surveys; return the survey's folder."""
    before = set(data.glob("*"))
    assert main(["import", str(path), str(data), "--format", form, *options]) in (0, 1)
    (folder,) = set(data.glob("*")) - before
    assert FOLDER_NAME.fullmatch(folder.name)
    return folder


@pytest.mark.parametrize("seed", range(4))
def test_the_formats_of_the_group_become_surveys_that_are_the_same(tmp_path, seed):
    survey, data = random_survey(seed), tmp_path / "data"
    for form, name in FORMATS.items():
        path = tmp_path / form / name
        path.parent.mkdir()
        export_survey(survey, path, form)
        folder = imported(path, form, data)
        found, verified = load_survey(folder), verify_survey(folder)
        entry = json.loads((folder / "survey.json").read_text("ascii"))["imported"]
        assert (entry["source"], entry["format"]) == (path.name, form)
        # The survey is another one, whose source it names.
        assert entry["survey_id"] == f"survey-{seed}"
        assert found.attrs["survey_id"] not in (entry["survey_id"], None)
        own = found.assign_attrs(survey_id=entry["survey_id"])
        same(own, survey, SINGLE if form == "merged-hdf5" else 0.0)
        assert verified.faults == [] and verified.imported is not None


def test_a_scans_become_spectra_or_are_refused(tmp_path, capsys):
    survey = random_survey(1)
    export_survey(to_time(survey), tmp_path / "scans", "group-csv")
    path, data = str(tmp_path / "scans"), tmp_path / "data"
    call = ["import", path, str(data), "--format", "group-csv"]
    assert main([*call, "--domain", "time"]) == 3
    assert "a_scan" in capsys.readouterr().err and not list(data.glob("*"))
    found = load_survey(imported(path, "group-csv", data))
    scale = np.nanmax(np.abs(survey.s21.values))
    np.testing.assert_allclose(found.s21.values, survey.s21.values, atol=1e-9 * scale)


def test_outputs_that_cannot_take_a_survey_are_refused(tmp_path, capsys):
    survey, data = random_survey(1), tmp_path / "data"
    export_survey(survey, tmp_path / "scans", "group-csv")
    folder = imported(tmp_path / "scans", "group-csv", data)
    (tmp_path / "file").write_text("")
    before = {one: one.stat().st_mtime_ns for one in tmp_path.rglob("*")}
    for output, reason in (
        (folder, "in the folder of the survey"),
        (folder / "traces", "in the folder of the survey"),
        (tmp_path / "scans", "is an input"),
        (tmp_path / "file", "is not a folder"),
        (tmp_path / "survey.h5", "must end in .nc, .zarr"),
    ):
        call = ["import", str(tmp_path / "scans"), str(output), "--format", "group-csv"]
        assert main(call) == 3
        assert reason in " ".join(capsys.readouterr().err.split())
    assert {one: one.stat().st_mtime_ns for one in tmp_path.rglob("*")} == before


def test_the_command_may_say_that_the_ground_is_real_but_not_of_simulated_data(tmp_path, capsys):
    survey, data = random_survey(1), tmp_path / "data"
    for name, simulated in (("simulated", 1), ("real", None)):
        own = survey.assign_attrs(simulated=simulated) if simulated else survey.copy()
        if not simulated:
            own.attrs.pop("simulated")
        export_survey(own, tmp_path / name, "group-csv")
    found = load_survey(imported(tmp_path / "real", "group-csv", data))
    assert "simulated" not in found.attrs
    found = load_survey(imported(tmp_path / "real", "group-csv", data, "--real-ground"))
    assert found.attrs["simulated"] == 0
    capsys.readouterr()
    call = ["import", str(tmp_path / "simulated"), str(data), "--format", "group-csv"]
    assert main([*call, "--real-ground"]) == 3
    assert "holds simulated data" in capsys.readouterr().err and len(list(data.glob("*"))) == 2
