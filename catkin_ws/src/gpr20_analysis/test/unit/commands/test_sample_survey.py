"""The sample survey is a whole recording of the simulated robot, and every command reads it."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.records import Chunk
from mcap.stream_reader import StreamReader

import gpr20_analysis
from gpr20_analysis import faults
from gpr20_analysis.commands.main import main

MOST_BYTES = 1_600_000


def test_it_is_small_whole_and_simulated():
    path = gpr20_analysis.sample_survey()
    assert path.stat().st_size < MOST_BYTES
    survey = gpr20_analysis.load_survey(path)
    assert survey.attrs["simulated"] and not survey.attrs["missing"] + survey.attrs["faults"]
    assert survey.s21.shape == (2, 21, 21, 101)
    assert np.isfinite(survey.height).all()
    lines = gpr20_analysis.summarize(survey)
    assert lines["VNA"].split(",")[2] == "SIMULATED" and "SIMULATED" in lines["ground"]


def test_the_command_writes_a_copy_and_replaces_nothing(tmp_path, refusals):
    output = tmp_path / "sample.mcap"
    assert main(["sample", str(output)]) == 0
    assert output.read_bytes() == gpr20_analysis.sample_survey().read_bytes()
    assert main(["sample", str(output)]) == 3
    assert refusals[-1:] == [faults.OUTPUT.code]
    assert main(["sample", str(output), "--overwrite"]) == 0


def test_each_trace_is_in_a_chunk_of_its_own_as_in_a_survey():
    with gpr20_analysis.sample_survey().open("rb") as file:
        records = StreamReader(file, emit_chunks=True).records
        chunks = sum(isinstance(one, Chunk) for one in records)
    # One more has what describes the survey.
    assert chunks == 2 * 21 * 21 + 1


@pytest.mark.parametrize("name", ["sample.nc", "sample"])
def test_the_copy_is_an_mcap(tmp_path, name, refusals):
    assert main(["sample", str(tmp_path / name)]) == 3
    assert refusals[-1:] == [faults.OUTPUT.code]
