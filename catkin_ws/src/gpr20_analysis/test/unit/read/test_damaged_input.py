"""Damaged input is refused by name, or left out and marked: never part of a picture unnoticed."""

import errno
import itertools
import json
import random
import re
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from fault_kit import raises_fault
from rosbags.rosbag1 import Writer
from run_seed import SEED, draws
from storage_kit import bag_messages, with_bag
from survey_kit import POINTS, SURVEY, make_survey, write_trace_file

from gpr20_analysis import errors
from gpr20_analysis.commands.main import main
from gpr20_analysis.dataset import Quality
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.formats.dataset_files import write_dataset
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.recordings import is_metadata_topic
from gpr20_analysis.read.replay import describe
from gpr20_survey import faults as survey_faults
from gpr20_survey.folder.survey_folder import LOG_FILES
from gpr20_survey.folder.trace_files import read_trace
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.trace import trace_message

pytestmark = pytest.mark.usefixtures("blank_figures")

ALL = len(POINTS)
VICTIM = 4
DONE, NOT_COMPLETE, DAMAGED, REFUSED = 0, 1, 2, 3
IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")
COMMANDS = {
    "info": ("info", "SURVEY"),
    "process": ("process", "SURVEY", "--step", "background", "-o", "OUT.nc"),
    "image": ("image", "SURVEY", *IMAGE, "--leave-out-missing", "-o", "OUT.nc"),
    "candidates": ("candidates", "SURVEY", *IMAGE, "--leave-out-missing", "-o", "OUT.csv"),
    "plot": ("plot", "coverage", "SURVEY", "-o", "OUT.png"),
    "export": ("export", "SURVEY", "OUT.csv", "--format", "csv"),
    "report": ("report", "SURVEY", *IMAGE, "-o", "OUT.html"),
}


def trace_file(folder, index=VICTIM):
    return next((folder / "traces").glob(f"{index:06d}_*"))


def change(folder, index=VICTIM, **entries):
    path = trace_file(folder, index)
    write_trace_file(path, {**json.loads(path.read_text()), **entries})


def truncate(folder):
    trace_file(folder).write_bytes(trace_file(folder).read_bytes()[:-20])


def elsewhere(folder):
    path = trace_file(folder)
    change(folder, x_coord_mm=11.0)
    path.rename(path.with_name(re.sub(r"X00\d\d", "X0011", path.name)))


def exchanged(folder):
    first, second = trace_file(folder), trace_file(folder, VICTIM + 1)
    content = first.read_bytes()
    first.write_bytes(second.read_bytes())
    second.write_bytes(content)


DAMAGES = {
    "truncated": truncate,
    "not a number": lambda folder: change(folder, s21_real=[0.0, 1.0, float("nan"), 2.0, 3.0]),
    "fewer points": lambda folder: change(
        folder, frequency_hz=[6e8, 6e9], s21_real=[0.0, 1.0], s21_imag=[0.0, 1.0]
    ),
    "elsewhere": elsewhere,
    "exchanged": exchanged,
    "of another survey": lambda folder: change(
        folder, survey_id="11111111-2222-3333-4444-555555555555"
    ),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_file_is_refused_by_name_and_marked_once_accepted(copied, finished, damage):
    DAMAGES[damage](copied)
    # Files alone do not tell which places were planned.
    for part in (copied,) if damage == "elsewhere" else (copied, copied / "traces"):
        with raises_fault(survey_faults.DAMAGED) as caught:
            load_survey(part)
        assert re.search(rf"\b{VICTIM}\b|{VICTIM:06d}_", str(caught.value))
    survey, good = load_survey(copied, accept_damaged=True), load_survey(finished)
    victims = [VICTIM, VICTIM + 1] if damage == "exchanged" else [VICTIM]
    spoilt = np.isin(good["index"].values, victims)
    unusable = int(Quality.DAMAGED | Quality.MISSING)
    assert ((survey.quality.values & unusable) != 0).tolist() == spoilt.tolist()
    assert np.isnan(survey.s21.values[spoilt]).all()
    np.testing.assert_array_equal(survey.s21.values[~spoilt], good.s21.values[~spoilt])
    assert survey.attrs["faults"] and len(survey.attrs["missing"]) == spoilt.sum()


def test_one_trace_or_place_twice_and_frequencies_that_no_half_shares_are_refused(copied, tmp_path):
    twice, place, halves = (
        Path(shutil.copytree(str(copied), str(tmp_path / name))) for name in "abc"
    )
    copy = json.loads(trace_file(twice).read_text())
    copy["z_coord_deg"] += 1.8
    turned = f"_Z{copy['z_coord_deg']:+07.2f}.json"
    name = trace_file(twice).name.rsplit("_Z", 1)[0]
    write_trace_file(twice / "traces" / f"{name}{turned}", copy)
    point, path = POINTS[VICTIM], trace_file(place, VICTIM + 1)
    change(place, VICTIM + 1, x_coord_mm=point.x_mm, y_coord_mm=point.y_mm, z_coord_deg=point.z_deg)
    other = trace_file(place).name.replace(f"{VICTIM:06d}", f"{VICTIM + 1:06d}")
    path.rename(path.with_name(other))
    for index in range(1, ALL):
        change(halves, index, frequency_hz=np.linspace(1e9, 6e9, 5).tolist())
    for part in (twice, twice / "traces", place / "traces"):
        with raises_fault(survey_faults.DAMAGED):
            load_survey(part)
    for part, lost in ((twice / "traces", [VICTIM]), (place / "traces", [VICTIM, VICTIM + 1])):
        found = load_survey(part, accept_damaged=True)["index"].values
        assert not np.isin(found, lost).any() and np.isin(VICTIM - 1, found)
    with raises_fault(survey_faults.DAMAGED):
        load_survey(halves, accept_damaged=True)


def test_positions_on_no_grid_are_refused(copied):
    for index in range(ALL):
        path = trace_file(copied, index)
        values = json.loads(path.read_text())
        path.unlink()
        x_mm, y_mm = round(10.0 + index**1.5, 2), round(10.0 + 3 * index**1.2, 2)
        values.update(x_coord_mm=x_mm, y_coord_mm=y_mm)
        name = f"{index:06d}_X{x_mm:07.2f}_Y{y_mm:07.2f}_Z{values['z_coord_deg']:+07.2f}.json"
        write_trace_file(copied / "traces" / name, values)
    with raises_fault(errors.INPUT):
        load_survey(copied / "traces")


def test_a_description_is_read_from_either_file_of_the_log_and_refused_without(copied, finished):
    good = load_survey(finished)
    for name in LOG_FILES:
        content = (copied / name).read_bytes()
        (copied / name).write_bytes(b"{")
        xr.testing.assert_identical(load_survey(copied), good.assign_attrs(source=copied.name))
        (copied / name).write_bytes(content)
    for name in LOG_FILES:
        (copied / name).write_text("{")
    with raises_fault(survey_faults.DAMAGED):
        load_survey(copied)


def run(command, source, tmp_path, *more):
    """Return the exit status and what was written, without the facts beside it."""
    there = Path(tempfile.mkdtemp(prefix=command, dir=str(tmp_path)))
    words = [one.replace("SURVEY", str(source)) for one in COMMANDS[command]]
    words = [one.replace("OUT", str(there / "result")) for one in words]
    status = main([*words, *more])
    return status, [
        one for one in there.iterdir() if not one.name.endswith((".csv.json", ".sha256"))
    ]


def test_every_command_refuses_damaged_files_until_they_are_accepted(copied, tmp_path, capsys):
    truncate(copied)
    with raises_fault(survey_faults.DAMAGED):
        read_trace(trace_file(copied))
    for command in COMMANDS:
        assert run(command, copied, tmp_path) == (REFUSED, []), command
        error = capsys.readouterr().err
        assert f"{VICTIM:06d}_" in error or f"trace {VICTIM}" in error, command
        status, written = run(command, copied, tmp_path, "--accept-damaged")
        assert status == DAMAGED, command
        assert len(written) == (command != "info"), command
        assert "DAMAGED: " in capsys.readouterr().err, command


def test_missing_samples_are_told_by_every_command_and_for_every_kind(tmp_path, capsys):
    cut_short = with_bag(make_survey(tmp_path / "short", ALL - 2, "stopped"))
    write_dataset(load_survey(cut_short), tmp_path / "s.nc")
    shutil.copytree(str(cut_short / "traces"), str(tmp_path / "traces"))
    trace_file(tmp_path, 3).unlink()  # nothing says that two more would have come
    kinds = (cut_short / "survey.bag", cut_short / "survey.mcap", tmp_path / "s.nc")
    for command, source in (
        *((command, cut_short) for command in COMMANDS),
        *(("process", one) for one in (*kinds, tmp_path / "traces")),
    ):
        status, written = run(command, source, tmp_path)
        assert status == NOT_COMPLETE, (command, source)
        assert len(written) == (command != "info"), (command, source)
        assert "NO DATA: missing: " in capsys.readouterr().err, (command, source)


def test_a_dataset_that_was_changed_or_cut_short_is_refused(finished, tmp_path, refusals, capsys):
    survey = load_survey(finished)
    path = tmp_path / "e.nc"
    assert main(["export", str(finished), str(path), "--format", "netcdf"]) == DONE
    content, draw = path.read_bytes(), random.Random(SEED)
    path.write_bytes(content[: len(content) // 2])
    assert run("process", path, tmp_path) == (REFUSED, []) and "e.nc" in capsys.readouterr().err
    refused = 0
    for _ in range(draws(40)):
        changed = bytearray(content)
        changed[draw.randrange(len(content))] ^= 1 << draw.randrange(8)
        path.write_bytes(changed)
        try:
            assert load_survey(path).equals(survey)
        except AnalysisError as error:
            assert error.message.fault_code == errors.FILE_DAMAGED.code
            refused += 1
    assert refused > 10
    refusals.clear()
    for order in (slice(None, None, -1), np.random.default_rng(1).permutation(5)):
        write_dataset(survey.isel(frequency=order), tmp_path / "s.nc")
        assert run("process", tmp_path / "s.nc", tmp_path) == (REFUSED, [])
        assert refusals[-1:] == [errors.FILE_DAMAGED.code]
    survey.s21[0, 1, 1, 3] = np.nan
    write_dataset(survey, tmp_path / "s.nc")
    for more in ((), ("--accept-damaged",)):
        assert run("info", tmp_path / "s.nc", tmp_path, *more) == (REFUSED, [])
        assert refusals[-1:] == [errors.FILE_DAMAGED.code]


def test_a_dataset_of_somebody_else_is_refused(tmp_path):
    xr.Dataset({"rain": ("day", [1.0, 2.0])}).to_netcdf(str(tmp_path / "w.nc"), engine="h5netcdf")
    assert main(["info", str(tmp_path / "w.nc")]) == REFUSED


@pytest.fixture(scope="module")
def recorded_folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("whole")
    return with_bag(make_survey(place, ALL, "finished", recorded=True))


def test_a_bag_of_another_recorder_is_read_by_its_index(recorded_folder, tmp_path):
    messages = bag_messages(recorded_folder / "survey.bag")
    for name, compression in (("none.bag", None), ("bz2.bag", Writer.CompressionFormat.BZ2)):
        bag, connections = Writer(tmp_path / name), {}
        if compression is not None:
            bag.set_compression(compression)
        with bag:
            for one in messages:
                if one.topic not in connections:
                    kind = one.datatype.replace("/", "/msg/")
                    connections[one.topic] = bag.add_connection(
                        one.topic, kind, msgdef=one.definition, md5sum=one.md5sum
                    )
                bag.write(connections[one.topic], one.time_ns, one.data)
        survey, good = load_survey(tmp_path / name), load_survey(recorded_folder)
        np.testing.assert_array_equal(survey.s21.values, good.s21.values)
        assert survey.attrs["survey_id"] == SURVEY


def test_a_recording_of_a_survey_of_another_version_is_refused_with_its_number(copied, tmp_path):
    file = McapFile(tmp_path / "later.mcap")
    for one in StoredMcap(copied / "survey.mcap").messages():
        data = one.data.replace(b"gpr20-survey/1", b"gpr20-survey/2")
        file.write(replace(one, data=data) if one.topic.endswith("metadata") else one)
    file.finish()
    with raises_fault(survey_faults.DAMAGED, "gpr20-survey/2"):
        load_survey(tmp_path / "later.mcap")


@pytest.mark.parametrize("name", ["survey.bag", "survey.bag.active"])
def test_a_bag_without_its_whole_index_is_refused_with_what_to_do_and_nothing_else(
    recorded_folder, tmp_path, name, capsys
):
    path, content = tmp_path / name, (recorded_folder / "survey.bag").read_bytes()
    place = content.index(b"index_pos=") + len(b"index_pos=")
    without = content[:place] + bytes(8) + content[place + 8 :]
    for one in (without, content[:-10], content[: len(content) // 2], content[:5000]):
        path.write_bytes(one)
        assert main(["info", str(path)]) == REFUSED
        said, remedy = capsys.readouterr().err.splitlines()
        assert f"{name} has no complete index" in said
        assert remedy == f"First: {errors.NO_INDEX.remedy}" and "rosbag reindex" in remedy


def test_what_is_damaged_in_a_recording_is_named(recorded_folder, tmp_path, monkeypatch):
    path, content = tmp_path / "survey.bag", (recorded_folder / "survey.bag").read_bytes()
    for place in (5000, len(content) // 2):
        path.write_bytes(content[:place] + bytes(40) + content[place + 40 :])
        with pytest.raises(AnalysisError):
            load_survey(path)
    whole = list(StoredMcap(recorded_folder / "survey.mcap").messages())
    path = tmp_path / "empty.mcap"
    file = McapFile(path)
    for one in whole:
        if one.datatype != trace_message.DATATYPE and not is_metadata_topic(one.topic):
            file.write(one)
    file.finish()
    with raises_fault(errors.INPUT, "its topics are: /"):
        describe(path)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2] + bytes(40) + content[len(content) // 2 + 40 :])
    for read in (describe, load_survey):
        with raises_fault(errors.FILE_DAMAGED):
            read(path)

    def failing(_self, datatype=""):
        wanted = (one for one in whole if datatype in ("", one.datatype))
        yield from itertools.islice(wanted, 5)
        raise OSError(errno.EIO, "Input/output error")

    monkeypatch.setattr(StoredMcap, "messages", failing)
    with raises_fault(survey_faults.DAMAGED, "Input/output error"):
        load_survey(recorded_folder / "survey.mcap")
    survey = load_survey(recorded_folder / "survey.mcap", accept_damaged=True)
    assert survey.attrs["stored"] == 5 and "Input/output error" in survey.attrs["faults"][0]
