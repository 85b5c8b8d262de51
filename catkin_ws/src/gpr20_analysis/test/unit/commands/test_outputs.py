"""Outputs are whole or not there, and what process, image and plot write."""

import json
import signal
from pathlib import Path

import numpy as np
import pytest
from command_kit import TIME_LIMIT_S, begun
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of
from survey_kit import POINTS

from gpr20_analysis.atomic_output import BESIDE, atomic_output
from gpr20_analysis.commands import image_commands
from gpr20_analysis.commands.command import DONE, REFUSED
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.common import as_dataset
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset
from gpr20_analysis.read.load import load_survey
from gpr20_common.faults import NOT_ALLOWED

ALL = len(POINTS)
IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")
# The arguments of a command that writes, and what it may replace.
WRITERS = [
    (("export", "SURVEY", "PLACE/o.nc", "--format", "netcdf"), "o.nc"),
    (("export", "SURVEY", "PLACE/o.csv", "--format", "csv"), "o.csv"),
    (("process", "SURVEY", "--step", "time", "-o", "PLACE/q.nc"), "q.nc"),
    (("image", "SURVEY", *IMAGE, "-o", "PLACE/i.nc"), "i.nc"),
    (("plot", "coverage", "SURVEY", "-o", "PLACE/c.png"), "c.png"),
    (("report", "SURVEY", *IMAGE, "-o", "PLACE/r.html"), "r.html"),
]  # fmt: skip


@pytest.mark.usefixtures("blank_figures")
@pytest.mark.parametrize(("arguments", "there"), WRITERS, ids=[there for _, there in WRITERS])
def test_what_exists_is_replaced_only_when_asked_for_and_never_in_a_survey(
    arguments, there, finished, tmp_path, capsys, refusals
):
    def call(place, *more):
        known = {"SURVEY": str(finished)}
        given = [known.get(one, one.replace("PLACE", str(place))) for one in arguments]
        return main([*given, *more])

    precious = tmp_path / there
    precious.write_text("precious")
    assert call(tmp_path) == 3
    assert there.split("_")[0] in capsys.readouterr().err
    assert precious.read_text() == "precious"
    assert call(tmp_path, "--overwrite") == 0
    assert precious.read_bytes() != b"precious"
    before = sorted(finished.rglob("*"))
    assert call(finished, "--overwrite") == 3
    assert refusals == 2 * [NOT_ALLOWED.code]
    assert sorted(finished.rglob("*")) == before


def test_a_folder_that_holds_something_is_never_replaced(finished, tmp_path, refusals):
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.txt").write_text("precious")
    home = str(tmp_path / "home")
    for call in (
        ("export", str(finished), home, "--format", "ros2", "--overwrite"),
        ("process", str(finished), "--step", "time", "-o", home + ".nc", "--overwrite"),
    ):
        if call[0] == "process":
            (tmp_path / "home").rename(home + ".nc")
        assert main(list(call)) == 3, call
    assert refusals == 2 * [NOT_ALLOWED.code]
    assert (tmp_path / "home.nc" / "thesis.txt").read_text() == "precious"


def test_what_is_read_and_what_is_no_folder_is_not_written(finished, tmp_path, refusals):
    path = tmp_path / "s.nc"
    assert main(["export", str(finished), str(path), "--format", "netcdf"]) == 0
    arguments = ["process", str(path), "--step", "background", "-o", str(path), "--overwrite"]
    assert main(arguments) == 3
    load_survey(path)
    (tmp_path / "file").write_text("")
    output = str(tmp_path / "file" / "x.nc")
    assert main(["process", str(finished), "--step", "background", "-o", output]) == 3
    assert refusals == [NOT_ALLOWED.code] * 2
    refused = raises_fault(NOT_ALLOWED, "/proc/x.nc")
    with refused, atomic_output(Path("/proc/x.nc")) as place:
        place.write_text("")


@pytest.mark.parametrize(
    ("ending", "there"),
    [(KeyboardInterrupt, True), (MemoryError, False), (OSError(28, "No space left"), True)],
)
def test_work_that_is_cut_off_leaves_nothing_half_written(
    finished, tmp_path, monkeypatch, capsys, ending, there
):
    output = tmp_path / "out" / "p.nc"
    if there:
        output.parent.mkdir()
        output.write_text("as before")

    def cut_off(data, path):
        with atomic_output(path) as place:
            place.write_text("half")
            raise ending

    monkeypatch.setattr(image_commands, "write_dataset", cut_off)
    arguments = ["process", str(finished), "--step", "background", "-o", str(output), "--overwrite"]
    assert main(arguments) == 3
    assert [one.name for one in output.parent.iterdir()] == (["p.nc"] if there else [])
    assert not there or output.read_text() == "as before"
    error = capsys.readouterr().err
    assert "Traceback" not in error and error.startswith("gpr20 process: ")


@pytest.fixture(scope="module")
def survey_file(tmp_path_factory):
    """A survey that takes long to write line by line."""
    count, path = 100, tmp_path_factory.mktemp("survey") / "s.nc"
    place_m, shape = np.arange(count) / 100.0, (2, count, count)
    s21, frequency_hz = np.ones((*shape, 51), complex), np.linspace(6e8, 6e9, 51)
    data = (s21, [0.0, 90.0], place_m, place_m, np.full(shape, 0.2), "slow")
    write_dataset(as_dataset(*data, frequency_hz), path)
    return path


def test_what_is_ended_leaves_nothing_behind(survey_file, tmp_path):
    call = ["export", str(survey_file), str(tmp_path / "out.csv"), "--format", "csv"]
    process = begun(call, lambda: list(tmp_path.glob(f"{BESIDE}*/out.csv")))
    try:
        process.send_signal(signal.SIGTERM)
        _, error = process.communicate(timeout=TIME_LIMIT_S)
    finally:
        process.kill()
    assert process.returncode == 3
    assert error.splitlines()[-1] == "gpr20 export: interrupted; no partial output is left"
    assert "Traceback" not in error
    assert list(tmp_path.iterdir()) == []


PLACES_MM = np.linspace(140.0, 340.0, 11)
TARGET = point(243.7, 236.2, 0.083)


@pytest.fixture(scope="module")
def ground_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("survey") / "survey.nc"
    write_dataset(survey_of(scene([TARGET]), PLACES_MM, PLACES_MM), path)
    return path


def printed(capsys, *arguments, status=DONE):
    assert main([str(one) for one in arguments]) == status
    return capsys.readouterr().out


def refused(capsys, *arguments):
    assert main([str(one) for one in arguments]) == REFUSED
    return capsys.readouterr().err


def test_processed_data_go_through_the_chain_and_record_it(ground_file, tmp_path, capsys):
    result, image = tmp_path / "clean.nc", tmp_path / "image.nc"
    chosen = ("--step", "background:method=mean")
    said = printed(capsys, "process", ground_file, *chosen, "-o", result)
    assert said.splitlines()[-1] == "background:method=mean,width=11"
    command = ("image", result, "--permittivity", 4, "--json", "-o", image)
    answer = json.loads(printed(capsys, *command))
    processing = json.loads(read_dataset(image).attrs["processing"])
    assert [one["method"] for one in processing] == ["mean"]
    echo = answer["candidates"][0]
    assert abs(echo["x_m"] * 1e3 - TARGET.x_mm) < 3.0
    assert abs(echo["depth_m"] - TARGET.depth_m) < 3e-3


@pytest.mark.usefixtures("blank_figures")
def test_plots_of_a_survey_are_written(ground_file, tmp_path, capsys):
    for kind, *options in (
        ("a-scan", "--x", "240", "--y", "240", "--until", "6"),
        ("b-scan", "--along", "y", "--x", "240", "--permittivity", "4"),
        ("c-scan", "--delay", "2.4"),
        ("coverage",),
        ("height",),
    ):
        picture = tmp_path / f"{kind}.svg"
        printed(capsys, "plot", kind, ground_file, *options, "-o", picture)
        assert picture.exists(), kind


WRONG_ARGUMENTS = (
    (("image", "SURVEY", "--permittivity", "0.2"), "between 1 and 100"),
    (("image", "SURVEY", "--depth", "0", "0.3", "0.3001"), "gives 1 depths; use 2 to 5000"),
    (("image", "SURVEY", "-o", "picture.jpg"), "must end in"),
    (("process", "SURVEY", "-o", "x.nc"), "no step was given"),
    (("plot", "a-scan", "SURVEY", "--x", "900", "-o", "x.png"), "must lie between 140 and 340 mm"),
    (("plot", "c-scan", "SURVEY", "--delay", "900", "-o", "x.png"), "--delay"),
    (("plot", "b-scan", "SURVEY", "--until", "0", "-o", "x.png"), "--until"),
)


def test_wrong_arguments_are_refused_with_a_reason(ground_file, capsys):
    for arguments, reason in WRONG_ARGUMENTS:
        given = [str(ground_file) if one == "SURVEY" else one for one in arguments]
        assert reason in refused(capsys, *given)
