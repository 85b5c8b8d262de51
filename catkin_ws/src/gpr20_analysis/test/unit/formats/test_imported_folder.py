"""Imported data become the folder of a survey: nothing is lost, and nothing of a plan invented."""

import glob
import json
import os
import random
import re
import shutil
import signal
import stat
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from result_examples import SOURCE, imported_folder, line_survey
from run_seed import draws
from wait_kit import wait_until

from gpr20_analysis import errors
from gpr20_analysis.atomic_output import BESIDE
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import QUALITY, SAMPLE_DIMS, Quality
from gpr20_analysis.errors import ExportError
from gpr20_analysis.formats.common import as_dataset
from gpr20_analysis.formats.imported_folder import ImportSource, write_imported_folder
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.verdict import INCOMPLETE
from gpr20_analysis.read.verification import verify_survey
from gpr20_analysis.sentences import with_doubts
from gpr20_common.message import Message
from gpr20_survey.files.regular_files import sum_of_file
from gpr20_survey.folder.survey_folder import FOLDER_NAME

NOTE = Message("the record was {length} long", length="8 ns")
DOUBT = Message("levels may be wrong").with_fault(errors.CALIBRATION)
CHILD = """
import sys
from pathlib import Path
from result_examples import imported_folder
print("begins", flush=True)
while True:
    imported_folder(Path(sys.argv[1]), 40, 3)
"""


@st.composite
def axes_m(draw, most=4):
    """Positions along an axis, ascending, even or not [m]."""
    gaps_mm = draw(st.lists(st.floats(0.5, 500.0), max_size=most - 1))
    start_mm = draw(st.floats(-900.0, 900.0))
    return np.cumsum([start_mm, *gaps_mm]) / 1000.0


@st.composite
def imported_surveys(draw):
    """Small surveys, lines and single stops too, with missing samples, heights and times."""
    turns_deg = draw(st.sampled_from([[0.0], [90.0], [0.0, 90.0], [-45.0, 0.0, 45.0]]))
    y_m, x_m = draw(axes_m()), draw(axes_m())
    shape = (len(turns_deg), len(y_m), len(x_m))
    random = np.random.default_rng(draw(st.integers(0, 1 << 32)))
    points = draw(st.integers(2, 9))
    parts = random.standard_normal((2, *shape, points)) * 10.0 ** random.uniform(-9, 3)
    s21 = parts[0] + 1j * parts[1]
    missing = random.random(shape) < draw(st.sampled_from([0.0, 0.3]))
    missing.flat[random.integers(missing.size)] = False
    s21[missing] = np.nan
    height_m = random.uniform(0.0, 0.5, shape)
    height_m[random.random(shape) < 0.2] = np.nan
    height_m[missing] = np.nan
    survey = as_dataset(
        s21, turns_deg, y_m, x_m, height_m, SOURCE.name,
        frequency_hz=np.cumsum(random.uniform(1e6, 1e9, points)),
        simulated=draw(st.sampled_from([None, False, True])),
        notes=[NOTE],
    )  # fmt: skip
    if draw(st.booleans()):
        times_us = 1_600_000_000_000_000 + random.integers(0, 10**9, shape)
        times = np.where(missing, np.datetime64("NaT", "us"), times_us.astype("datetime64[us]"))
        survey["timestamp"] = (survey["timestamp"].dims, times.astype("datetime64[ns]"))
    survey = with_doubts(survey, DOUBT)
    return survey.assign_attrs(site="Facatativá", antenna_delay_s=1.5e-9, processing="[]")


@settings(max_examples=draws(10))
@given(survey=imported_surveys())
def test_random_data_come_back_as_they_were(survey, tmp_path_factory):
    folder = write_imported_folder(survey, tmp_path_factory.mktemp("data"), SOURCE)
    for path in (folder, folder / "survey.mcap"):
        found = load_survey(path)
        for axis in (*SAMPLE_DIMS, "frequency"):
            # A position in mm has a last bit of its own.
            np.testing.assert_allclose(found[axis].values, survey[axis].values, rtol=5e-16)
        for name in ("s21", "height", "timestamp", "remarks"):
            np.testing.assert_array_equal(found[name].values, survey[name].values)
        np.testing.assert_array_equal(found[QUALITY].values, survey[QUALITY].values)
        assert found.attrs["missing"] == survey.attrs["missing"]
        assert found.attrs["notes"] == [str(NOTE)]
        assert str(DOUBT) in found.attrs["doubts"]
        for name in ("simulated", "site", "processing", "antenna_delay_s"):
            assert found.attrs.get(name) == survey.attrs.get(name)
        assert "planned" not in found.attrs
    verified = verify_survey(folder)
    assert (verified.faults, verified.status, verified.sealed) == ([], INCOMPLETE, True)


def test_what_is_not_known_is_absent_and_the_source_is_named(tmp_path):
    folder = imported_folder(tmp_path)
    description = json.loads((folder / "survey.json").read_text("ascii"))
    names = {"parameters", "axes", "instrument", "settings", "planned_traces", "nodes", "report"}
    names |= {"software_revision", "analyzer"}
    assert not names & description.keys()
    entry = description["imported"]
    assert (entry["source"], entry["format"], entry["files"]) == ("line 7.dzt", "dzt", 1)
    assert (entry["sha256"], entry["times_known"]) == (SOURCE.sha256, False)
    found = verify_survey(folder)
    assert str(found.verdict).startswith("IMPORTED, files intact: 5 traces")
    assert "complete" not in str(found.verdict).lower()
    assert (found.planned, found.stored, found.record()["imported"]) == (None, 5, True)


def test_a_missing_trace_is_named_and_the_survey_is_to_be_imported_again(tmp_path):
    folder = imported_folder(tmp_path)
    (trace,) = (folder / "traces").glob("000003_*")
    trace.unlink()
    found = verify_survey(folder)
    assert found.verdict.fault_code == errors.FILE_DAMAGED.code
    survey = load_survey(folder)
    assert survey.attrs["missing"] == ["missing: x 60 mm, y 0 mm, 0 deg"]


def test_a_lost_manifest_is_repaired_and_notes_can_be_added(tmp_path, capsys):
    folder = imported_folder(tmp_path)
    (folder / "manifest.json").unlink()
    assert main(["verify", "--repair", str(folder)]) == INCOMPLETE
    assert main(["annotate", str(folder), "--name", "Line 7"]) == 0
    assert verify_survey(folder).faults == []
    assert load_survey(folder).attrs["survey_name"] == "Line 7"
    capsys.readouterr()
    assert main(["info", str(folder)]) == 0
    assert "imported from line 7.dzt (dzt)" in capsys.readouterr().out


@pytest.mark.parametrize("seed", range(draws(1)))
def test_an_import_that_is_killed_leaves_nothing_that_is_listed(tmp_path, seed):
    process = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(tmp_path)],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert process.stdout.readline() == "begins\n"
    wanted, traces = random.Random(seed).randrange(1, 120), f"{tmp_path}/{BESIDE}*/*/traces/*.json"
    # On a busy computer it may end before this process looks.
    wait_until(lambda: process.poll() is not None or len(glob.glob(traces)) >= wanted)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    listed = [one for one in tmp_path.iterdir() if FOLDER_NAME.fullmatch(one.name)]
    for folder in listed:
        assert verify_survey(folder).faults == []
    others = {one.name for one in tmp_path.iterdir()} - {one.name for one in listed}
    assert all(one.startswith(BESIDE) for one in others)
    imported_folder(tmp_path)


def test_data_that_a_survey_cannot_hold_leave_nothing(tmp_path):
    line = line_survey()
    far = line.assign_coords(x=line["x"] + 11.0)
    none = line.assign({QUALITY: line[QUALITY] * 0 + int(Quality.MISSING)})
    cases = (
        (to_time(line), "a_scan"),
        (far, "x_coord_mm"),
        (none, "no sample with data"),
        (line.assign(moisture=line["height"]), "moisture"),
        (line.assign_coords(frequency=-line["frequency"].values[::-1]), "frequency_hz"),
    )
    for survey, reason in cases:
        with pytest.raises(ExportError, match=f"{reason}.*write a .nc"):
            write_imported_folder(survey, tmp_path / "data", SOURCE)
        assert not list(tmp_path.glob("data/*"))

    def fail(items, _total):
        shutil.rmtree(next(tmp_path.glob(f"{BESIDE}*/*/traces")))
        return items

    with pytest.raises(ExportError, match="cannot be written"):
        write_imported_folder(line, tmp_path, SOURCE, fail)
    assert not list(tmp_path.glob(f"{BESIDE}*"))


def test_sha256sum_checks_files_of_any_name(tmp_path):
    (tmp_path / "scans").mkdir()
    for name in (b"a.csv", b"a b\\c\nd.csv", b"\xff\xfe.csv"):
        (tmp_path / "scans" / os.fsdecode(name)).write_bytes(name)
    source = ImportSource.of(tmp_path / "scans", "csv")
    (tmp_path / "list").write_bytes(source.listed())
    assert source.sha256 == sum_of_file(tmp_path / "list").sha256
    command = ["sha256sum", "--strict", "--quiet", "-c", "../list"]
    assert subprocess.run(command, cwd=str(tmp_path / "scans")).returncode == 0
    assert (source.name, len(source.sums), source.size) == ("scans", 3, 5 + 11 + 6)
    for name in ("LINE.DT1", "LINE.hd", "line2.hd", "LINE.nc"):
        (tmp_path / "scans" / name).write_text(name)
    both = ImportSource.of(tmp_path / "scans" / "LINE.DT1", "dt1")
    assert sorted(both.sums) == ["LINE.DT1", "LINE.hd"] and both.size == 15


def test_the_name_of_the_folder_is_that_of_a_survey_at_the_time_of_its_first_sample(tmp_path):
    tmp_path.chmod(0o750)
    survey = line_survey()
    times = np.datetime64("2026-03-04T05:06:07", "ns") + np.arange(5) * np.timedelta64(1, "s")
    survey["timestamp"] = (SAMPLE_DIMS, times.reshape(1, 1, 5))
    folder = write_imported_folder(survey, tmp_path, SOURCE)
    assert re.fullmatch("20260304T050607_[0-9a-f]{8}", folder.name)
    # Who may read the folder of the surveys may read an import.
    for one, mode in ((folder / "traces", 0o750), (folder / "survey.json", 0o640)):
        assert stat.S_IMODE(one.stat().st_mode) == mode
    assert load_survey(folder).attrs["ended"] == "2026-03-04T05:06:11.000000+00:00"
