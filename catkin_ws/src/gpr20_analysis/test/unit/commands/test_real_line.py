"""`gpr20 sample --real` writes a line over real ground, whose bars the default command finds."""

import json

import numpy as np
import pytest

from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample.real_line import REAL_LINE_FILE, real_line

BAR_M = 0.015


@pytest.mark.parametrize("name", ["line.nc", "line.zarr"])
def test_its_bars_are_the_first_candidates(tmp_path, capsys, name):
    path = str(tmp_path / name)
    assert main(["sample", "--real", path]) == 0
    capsys.readouterr()
    assert main(["candidates", path, "--permittivity", "6", "--json"]) == 0
    candidates = json.loads(capsys.readouterr().out)["candidates"][:14]
    with np.load(str(REAL_LINE_FILE)) as file:
        bars_m, depths_m = file["rebar_x_m"], file["rebar_published_depth_m"]
    away_m = np.abs(np.array([one["x_m"] for one in candidates])[:, None] - bars_m)
    assert sorted(away_m.argmin(axis=1)) == list(range(14)) and away_m.min(axis=1).max() < BAR_M
    assert all(0.05 < one["depth_m"] < 0.1 for one in candidates), depths_m


def test_it_says_where_it_is_from_and_what_was_assumed(tmp_path):
    main(["sample", "--real", str(tmp_path / "line.nc")])
    line = load_survey(tmp_path / "line.nc")
    assert "CHARISMA" in line.attrs["survey_notes"] and "CC0" in line.attrs["survey_notes"]
    assert "assumed" in line.attrs["notes"][0]
    assert line.attrs["simulated"] == 0 and line.attrs["missing"] == []
    np.testing.assert_array_equal(line.s21.values, real_line().s21.values)


def test_an_output_with_another_ending_and_one_that_exists_are_refused(tmp_path, capsys):
    assert main(["sample", "--real", str(tmp_path / "line.mcap")]) == 3
    assert "must end in .nc, .zarr" in capsys.readouterr().err
    (tmp_path / "line.nc").write_text("kept")
    assert main(["sample", "--real", str(tmp_path / "line.nc")]) == 3
    assert (tmp_path / "line.nc").read_text() == "kept"
    assert main(["sample", str(tmp_path / "s.nc")]) == 3
