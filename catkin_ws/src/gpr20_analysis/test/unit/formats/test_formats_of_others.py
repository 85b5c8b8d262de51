"""Others read what is exported; it says that it is simulated."""

import os
import stat

import pandas as pd
import pytest
from random_surveys import random_survey
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality, usable
from gpr20_analysis.formats.exports import export_survey
from gpr20_analysis.read.load import load_survey

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


def test_pandas_reads_the_plain_table(survey, folder, tmp_path):
    assert export(folder, tmp_path / "t.csv", "csv") == 0
    table = pd.read_csv(tmp_path / "t.csv", float_precision="round_trip")
    assert table["simulated"].tolist() == [1] * ALL
    row = table[table["index"] == 7].iloc[0]
    own = survey.s21.values[survey["index"].values == 7][0]
    assert row["real_600000000.0_hz"] == own[0].real
    assert row["imag_6000000000.0_hz"] == own[-1].imag


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_who_may_read_an_export_is_as_the_umask_says(folder, tmp_path, mask):
    former = os.umask(mask)
    try:
        for form, name in (("csv", "t.csv"), ("bag", "t.bag"), ("netcdf", "t.nc")):
            assert export(folder, tmp_path / name, form) == 0
            mode = stat.S_IMODE((tmp_path / name).stat().st_mode)
            assert mode == 0o666 & ~mask, name
    finally:
        os.umask(former)


def test_all_data_are_said_to_be_in_a_file_only_where_they_are(survey, tmp_path):
    for index, said in ((-1, f"all data, {ALL} samples"), (3, f"{ALL - 1} of {ALL} samples; ")):
        lost = survey["index"] == index
        less = survey.assign(quality=survey.quality.where(~lost, int(Quality.MISSING)))
        assert str(export_survey(less, tmp_path / "s.nc", "netcdf")).startswith(said)


def test_a_table_has_a_line_for_each_sample_with_data_and_no_other(tmp_path):
    for seed in range(3):
        survey = random_survey(seed)
        said = export_survey(survey, tmp_path / f"{seed}.csv", "csv")
        table = pd.read_csv(tmp_path / f"{seed}.csv")
        own = survey["index"].values[usable(survey).values]
        assert sorted(table["index"]) == sorted(own)
        assert str(said) == f"{own.size} samples"
