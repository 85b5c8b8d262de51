"""Outputs are whole or not there, never replaced unasked, and never among what was measured."""

from __future__ import annotations

from pathlib import Path

import pytest
from fault_kit import raises_fault
from survey_kit import POINTS, make_survey

from gpr20_analysis import faults
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.commands import process_command
from gpr20_analysis.commands.main import main
from gpr20_analysis.read.load import load_survey

ALL = len(POINTS)
IMAGE = ("--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03")
# What is written, and its kind: the command's arguments stand around the path.
WRITERS = {
    "netcdf": ("export", "SURVEY", "o.nc", "--format", "netcdf"),
    "zarr": ("export", "SURVEY", "o.zarr", "--format", "zarr"),
    "csv": ("export", "SURVEY", "o.csv", "--format", "csv"),
    "touchstone": ("export", "SURVEY", "ts", "--format", "touchstone"),
    "segy": ("export", "SURVEY", "o_090.sgy", "--format", "segy"),
    "processed": ("process", "SURVEY", "--step", "background", "-o", "p.nc"),
    "recipe": ("process", "SURVEY", "--step", "time", "-o", "q.nc", "--save-recipe", "r.yaml"),
    "image": ("image", "SURVEY", *IMAGE, "-o", "i.nc"),
    "vtk": ("image", "SURVEY", *IMAGE, "-o", "i.vtr"),
    "figures": ("image", "SURVEY", *IMAGE, "--figures", "figures"),
    "plot": ("plot", "coverage", "SURVEY", "-o", "c.png"),
    "report": ("report", "SURVEY", *IMAGE, "-o", "r.html"),
}  # fmt: skip
OUTPUT = {"recipe": "r.yaml", "figures": "figures"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_survey(tmp_path_factory.mktemp("whole"), ALL, "finished")


@pytest.fixture(params=WRITERS)
def call(request, folder, tmp_path, monkeypatch):
    """Return the arguments of a command that writes, and the path of its output."""
    monkeypatch.chdir(tmp_path)
    arguments = [str(folder) if one == "SURVEY" else one for one in WRITERS[request.param]]
    named = [one for one in arguments if "/" not in one and (tmp_path / one).suffix]
    output = OUTPUT.get(request.param) or (named or [arguments[2]])[-1]
    return [one.replace("_090.sgy", ".sgy") for one in arguments], tmp_path / output


def occupy(output):
    """Put something there that an output of this name may replace."""
    if output.suffix == ".zarr":
        output.mkdir()
        (output / ".zgroup").write_text("precious")
        return output / ".zgroup"
    names = {"ts": "000001_X1_Y1_Z0.s2p", "figures": "slice_0001mm.png"}
    if output.suffix:
        output.write_text("precious")
        return output
    output.mkdir()
    (output / names[output.name]).write_text("precious")
    return output / names[output.name]


@pytest.mark.usefixtures("blank_figures")
def test_what_exists_is_replaced_only_when_asked_for_and_never_in_a_survey(
    call, folder, capsys, refusals
):
    arguments, output = call
    precious = occupy(output)
    assert main(arguments) == 3
    error = capsys.readouterr().err
    assert output.name in error and refusals == [faults.OUTPUT.code]
    assert precious.read_text() == "precious"
    assert main([*arguments, "--overwrite"]) == 0
    assert output.exists()
    assert not precious.exists() or precious.read_bytes() != b"precious"
    before = sorted(folder.rglob("*"))
    name = output.name.replace("_090", "")
    inside = [str(folder / name) if one == name else one for one in arguments]
    assert inside != arguments
    assert main([*inside, "--overwrite"]) == 3
    assert refusals == 2 * [faults.OUTPUT.code]
    assert sorted(folder.rglob("*")) == before


def test_a_folder_with_other_things_in_it_is_never_deleted(folder, tmp_path, capsys):
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "thesis.txt").write_text("precious")
    arguments = ["export", str(folder), str(tmp_path / "home"), "--format", "touchstone"]
    assert main([*arguments, "--overwrite"]) == 3
    assert "thesis.txt" in capsys.readouterr().err
    assert (tmp_path / "home" / "thesis.txt").read_text() == "precious"


def test_traces_of_a_survey_are_no_output_that_may_be_replaced(folder, capsys):
    arguments = ["export", str(folder), str(folder / "traces"), "--format", "touchstone"]
    assert main([*arguments, "--overwrite"]) == 3
    assert len(list((folder / "traces").iterdir())) == ALL


def test_what_is_read_is_not_written(folder, tmp_path, refusals):
    path = tmp_path / "s.nc"
    assert main(["export", str(folder), str(path), "--format", "netcdf"]) == 0
    arguments = ["process", str(path), "--step", "background", "-o", str(path), "--overwrite"]
    assert main(arguments) == 3
    assert refusals[-1:] == [faults.OUTPUT.code]
    load_survey(path)


def test_one_name_for_two_outputs_is_refused(folder, tmp_path, refusals):
    path = str(tmp_path / "i.nc")
    assert main(["image", str(folder), *IMAGE, "-o", path, "-o", path]) == 3
    assert refusals[-1:] == [faults.OUTPUT.code]


@pytest.mark.parametrize("ending", [KeyboardInterrupt, MemoryError, OSError(28, "No space left")])
@pytest.mark.parametrize("there", [True, False])
def test_work_that_is_cut_off_leaves_nothing_half_written(
    folder, tmp_path, monkeypatch, capsys, ending, there
):
    output = tmp_path / "out" / "p.nc"
    if there:
        output.parent.mkdir()
        output.write_text("as before")

    def cut_off(data, path):
        with atomic_output(path) as place:
            place.write_text("half")
            raise ending

    monkeypatch.setattr(process_command, "write_dataset", cut_off)
    arguments = ["process", str(folder), "--step", "background", "-o", str(output), "--overwrite"]
    assert main(arguments) == 3
    assert [one.name for one in output.parent.iterdir()] == (["p.nc"] if there else [])
    assert not there or output.read_text() == "as before"
    error = capsys.readouterr().err
    assert "Traceback" not in error and error.startswith("gpr20 process: ")


def test_a_place_that_cannot_be_written_is_told_before_any_work(folder, tmp_path, refusals):
    (tmp_path / "file").write_text("")
    output = str(tmp_path / "file" / "x.nc")
    assert main(["process", str(folder), "--step", "background", "-o", output]) == 3
    assert refusals[-1:] == [faults.OUTPUT.code]


def test_a_disk_that_refuses_is_told_with_the_outputs_own_name():
    refused = raises_fault(faults.OUTPUT, "/proc/x.nc")
    with refused, atomic_output(Path("/proc/x.nc")) as place:
        place.write_text("")


def test_names_with_spaces_and_accents_are_names(folder, tmp_path, capsys):
    survey = tmp_path / "campo número 3"
    survey.symlink_to(folder)
    output = tmp_path / "imágenes del día" / "señal ñ.nc"
    assert main(["process", str(survey), "--step", "background", "-o", str(output)]) == 0
    figure = tmp_path / "imágenes del día" / "corte β.png"
    assert main(["plot", "coverage", str(output), "-o", str(figure)]) == 0
    assert figure.stat().st_size > 1000
