"""Formats and methods of other packages: two pages of docs/extend, and what they may not do."""

import re
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from command_kit import install
from fault_kit import raises_fault
from tutorial_code import code_blocks

from gpr20_analysis import entry_points, faults
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.conversion import EXPORTS, export_format
from gpr20_analysis.formats.format import IMAGE_FORMATS, IMPORTS
from gpr20_analysis.imaging.methods import METHODS, imaging_method
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample.sample_survey import sample_survey

PAGES = {
    name: Path(__file__).parents[6] / f"docs/extend/{page}.md"
    for name, page in (("my_formats", "format"), ("my_methods", "imaging_method"))
}
POINTS = (EXPORTS, IMPORTS, IMAGE_FORMATS, METHODS)
ABSENT = [(point, name) for point in POINTS for name in point.wings]


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder with the packages of the pages, as pip installs them."""
    folder = tmp_path / "site"
    for name, page in PAGES.items():
        sections = re.findall(
            r'^\[project\.entry-points\."(.+)"\]\n(.+)\n',
            code_blocks(page, "toml")["pyproject.toml"],
            re.MULTILINE,
        )
        entries = [f"[{group}]\n{line}\n".replace('"', "") for group, line in sections]
        install(folder, "".join(entries), name.replace("_", "-"))
        (folder / f"{name}.py").write_text(code_blocks(page, "python")[f"{name}.py"])
    monkeypatch.syspath_prepend(folder)
    yield folder
    for name in PAGES:
        sys.modules.pop(name, None)


@pytest.fixture
def without_others(monkeypatch):
    """Nothing is installed that adds anything."""
    monkeypatch.setattr(entry_points, "additions", lambda group: [])


@pytest.fixture
def sample(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "survey.mcap"]) == 0


def test_a_format_of_a_page_writes_and_reads_a_survey(site, sample):
    for line in re.findall(r"^gpr20 (export|import)(.+)$", PAGES["my_formats"].read_text(), re.M):
        assert main([line[0], *shlex.split(line[1])]) == 0
    found, expected = load_survey("survey.nc"), load_survey(sample_survey())
    np.testing.assert_array_equal(found.s21, expected.s21)
    assert found.attrs["simulated"] == expected.attrs["simulated"] == 1


def test_files_of_a_format_of_a_package_are_recognized(site, sample):
    assert main(["export", "survey.mcap", "survey.npz", "--format", "numpy"]) == 0
    command = "gpr20 import survey.npz survey.nc --format numpy"
    with raises_fault(faults.IMPORT_FIRST, command):
        load_survey("survey.npz")


def test_a_method_of_a_package_makes_an_image(site, sample):
    (line,) = re.findall(r"^gpr20 (image .+)$", PAGES["my_methods"].read_text(), re.MULTILINE)
    assert main(shlex.split(line)) == 0
    image = load_survey("image.nc")
    assert image.attrs["method"] == "columns" and np.abs(image.image).max() > 0.0
    with raises_fault(faults.OPTION):
        imaging_method("no_such_method")


def test_what_cannot_be_used_is_refused_with_the_package_and_the_reason(site):
    (site / "my_formats.py").write_text("EXPORT = 'netcdf'\n")
    origin = "my-formats 1.0, my_formats"
    with raises_fault(faults.ADDITION, f"{origin}:EXPORT", "str", "ExportFormat"):
        export_format("numpy")
    with raises_fault(faults.ADDITION, f"{origin}:IMPORT", "AttributeError"):
        IMPORTS.find("numpy")
    install(site, "[gpr20_analysis.exports]\nnumpy = other:EXPORT\n", "other")
    with raises_fault(faults.ADDITION, f"{origin}:EXPORT", "other 1.0, other:EXPORT"):
        export_format("numpy")


def test_a_package_that_cannot_be_used_does_not_keep_surveys_from_being_read(site, sample):
    (site / "my_formats.py").write_text("1 / 0\n")
    assert load_survey("survey.mcap").attrs["simulated"] == 1


def test_no_package_replaces_a_format_or_a_method_of_gpr20(site):
    install(site, "[gpr20_analysis.exports]\ncsv = other:EXPORT\n", "other")
    assert EXPORTS.find("csv") is EXPORTS.own["csv"]
    assert EXPORTS.names().count("csv") == 1


@pytest.mark.parametrize(("point", "name"), ABSENT)
def test_what_an_absent_package_of_the_project_has_is_listed_and_named(without_others, point, name):
    assert name in point.names() and name not in point.added()
    with raises_fault(faults.LIBRARY, f"pip install 'catkin_ws/src/{point.wings[name]}'"):
        point.find(name)


@pytest.mark.parametrize(
    "arguments",
    [
        ("import", "there", "x.nc", "--format", "gprmax"),
        ("export", "survey.mcap", "x.h5", "--format", "merged-hdf5"),
        ("image", "survey.mcap", "-o", "x.h5"),
        ("image", "survey.mcap", "--method", "kirchhoff"),
        ("info", "image.h5"),
    ],
)
def test_a_command_names_the_absent_package(without_others, sample, refusals, capsys, arguments):
    for name in ("there", "image.h5"):
        Path(name).write_text("")
    assert main(list(arguments)) == 3
    assert refusals == [faults.LIBRARY.code]
    assert "catkin_ws/src/gpr20_foreign_formats" in capsys.readouterr().err
