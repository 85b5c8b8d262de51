"""Commands, formats, methods and steps of other packages: docs/extend, and what they may not do."""

import itertools
import re
import shlex
import sys
import tempfile
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from case_kit import each_case
from command_kit import install
from fault_kit import raises_fault
from tutorial_code import code_blocks

from gpr20_analysis import entry_points, errors
from gpr20_analysis.commands import command
from gpr20_analysis.commands.main import main
from gpr20_analysis.formats.imports import import_survey
from gpr20_analysis.imaging.image_options import imaging_method
from gpr20_analysis.processing.chain import (
    apply_steps,
    recorded_steps,
    step_from_text,
    text_of,
)
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample import sample_survey
from gpr20_common.faults import NOT_ALLOWED

DOCS = Path(__file__).parents[6] / "docs/extend"
PAGES = {"my_commands": "command", "my_formats": "format", "my_methods": "imaging_method"}
TEXTS = {name: (DOCS / f"{page}.md").read_text() for name, page in PAGES.items()}
STEP_PAGE = DOCS / "processing_step.md"
SUMMARY = "print 100 % of the corners"

# The modules of the page on steps, importable as those of an installed package are.
_folder = tempfile.TemporaryDirectory()
STEP_CODE = {}
for _kind in ("python", "toml"):
    STEP_CODE.update(code_blocks(STEP_PAGE, _kind))
for _name, _code in STEP_CODE.items():
    Path(_folder.name, _name).write_text(_code)
sys.path.insert(0, _folder.name)

from test_my_steps import *  # noqa: E402, F403


def entries_of(code):
    """Return the entry points of a page, in the form of a file entry_points.txt."""
    found = re.findall(r'^\[project\.entry-points\."(.+)"\]\n(.+)\n', code, re.MULTILINE)
    return "".join(f"[{group}]\n{line}\n".replace('"', "") for group, line in found)


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder with the packages of the pages, as pip installs them."""
    folder = tmp_path / "site"
    for name, page in PAGES.items():
        entries = entries_of(code_blocks(DOCS / f"{page}.md", "toml")["pyproject.toml"])
        install(folder, entries, name.replace("_", "-"), summary=SUMMARY)
        code = code_blocks(DOCS / f"{page}.md", "python")[f"{name}.py"]
        (folder / f"{name}.py").write_text(code)
    install(folder, entries_of(STEP_CODE["pyproject.toml"]), "my-steps")
    monkeypatch.syspath_prepend(folder)
    yield folder
    for name in PAGES:
        sys.modules.pop(name, None)


@pytest.fixture
def without_others(monkeypatch):
    """Nothing is installed that adds anything."""
    for module in (command, entry_points):
        monkeypatch.setattr(module, "additions", lambda group: [])


@pytest.fixture
def sample(tmp_path, monkeypatch):
    """The sample survey, which the pages call survey.mcap, where commands are called."""
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "survey.mcap"]) == 0
    return load_survey(sample_survey())


def calls_in(text, pattern):
    return [shlex.split(one) for one in re.findall(rf"^gpr20 ({pattern})$", text, re.MULTILINE)]


def test_a_command_of_a_page_runs_and_is_listed_without_an_import(site, sample, capsys):
    assert main(["--help"]) == command.DONE
    assert re.search(rf"corners +{SUMMARY}", capsys.readouterr().out)
    assert "my_commands" not in sys.modules
    for call in calls_in(TEXTS["my_commands"], r"(?!sample)\w+ survey.mcap"):
        assert main(call) == command.DONE
    assert re.search(r"^x: \S+ to \S+ m\ny: \S+ to \S+ m$", capsys.readouterr().out, re.MULTILINE)


def test_no_package_replaces_what_gpr20_or_another_package_has(site, refusals, capsys):
    install(site, "[gpr20.commands]\ncorners = other:CORNERS\nverify = none:X\n", "other")
    assert main(["corners", "x"]) == command.REFUSED and refusals == [errors.STEPS.code]
    error = capsys.readouterr().err
    assert "my-commands 1.0, my_commands:" in error and "other 1.0, other:CORNERS" in error
    assert main(["verify", "--help"]) == main(["--help"]) == command.DONE


@each_case("code, shown", [("1 / 0", "ZeroDivisionError"), ("CORNERS = 'print'", "str")])
def test_a_command_that_cannot_be_used_is_refused_with_the_reason(site, capsys, code, shown):
    (site / "my_commands.py").write_text(code)
    sys.modules.pop("my_commands", None)
    assert main(["corners", "x"]) == command.REFUSED
    error = capsys.readouterr().err
    assert "my-commands 1.0, my_commands:CORNERS" in error and shown in error
    assert "Traceback" not in error and len(error.splitlines()) <= 2
    # The others are not touched by it.
    assert main(["info", "--help"]) == main(["--help"]) == command.DONE


def test_a_command_names_the_absent_package(without_others, sample, refusals, capsys):
    Path("there").write_text("")
    for arguments, package in (
        (["view", "x"], "gpr20_viewer"),
        (["import", "there", "x.nc", "--format", "gprmax"], "gpr20_foreign_formats"),
    ):
        assert main(arguments) == 3 and refusals.pop() == errors.STEPS.code
        assert f"catkin_ws/src/{package}" in capsys.readouterr().err


def test_a_format_of_a_page_is_imported_and_recognized(site, sample):
    Path("line.scan").write_text(code_blocks(DOCS / "format.md", "text")["line.scan"])
    for call in calls_in(TEXTS["my_formats"], "(?:import|info).+"):
        assert main(call) == 0
    found = load_survey("line.nc")
    np.testing.assert_array_equal(found.s21.values[0, 0], [[1, 1j, -1], [1, -1j, -1]])
    assert found.x.values.tolist() == [0.0, 0.02] and (found.height == 0.1).all()
    with raises_fault(errors.INPUT, "gpr20 import line.scan survey.nc --format scan"):
        load_survey("line.scan")
    Path("line.scan").write_text("no numbers")
    with raises_fault(errors.INPUT, "not a file of the kind scan"):
        import_survey("line.scan", "scan")
    assert load_survey("survey.mcap").attrs["simulated"] == 1


def test_a_method_of_a_package_makes_an_image(site, sample):
    (call,) = calls_in(TEXTS["my_methods"], "image .+")
    assert main(call) == 0
    image = load_survey("image.nc")
    assert image.attrs["method"] == "columns" and np.abs(image.image).max() > 0.0
    with raises_fault(NOT_ALLOWED):
        imaging_method("no_such_method")


def never(path):
    raise AssertionError(path)


def test_the_result_names_an_installed_step_and_its_version(site, sample, capsys):
    assert main(["process", "--help"]) == command.DONE
    assert re.search(r"\bnotch\b", " ".join(capsys.readouterr().out.split()))
    texts = ("notch:center_hz=1.8e9", "background")
    result = apply_steps(sample, [step_from_text(one) for one in texts], never)
    notch, background = recorded_steps(result)
    assert notch["origin"] == "my-steps 1.0, my_steps:notch"
    assert "origin" not in background
    # What is recorded makes the same again.
    again = [step_from_text(text_of(one)) for one in recorded_steps(result)]
    assert apply_steps(sample, again, never).identical(result)
    for name in ("my_steps:notch", "os:system", "my_steps.notch"):
        with raises_fault(errors.STEPS):
            step_from_text(f"{name}:center_hz=1e9")


NUMBERS = itertools.count()


def own_step(site, code, text="own"):
    """Return the step of an installed package."""
    name = f"own{next(NUMBERS)}"
    (site / f"{name}.py").write_text(code)
    with pytest.MonkeyPatch.context() as patched:
        added = entry_points.Addition(EntryPoint("own", f"{name}:own", "steps"), "own 1.0", "")
        patched.setattr(entry_points, "additions", lambda _group: [added])
        return step_from_text(text)


def test_a_step_that_cannot_be_used_is_refused_with_the_reason(site):
    with raises_fault(errors.STEPS, "names"):
        own_step(site, "def own(survey, names: list): return survey", "own:names=1")


@each_case(
    "body, shown",
    [
        ("None", "NoneType"),
        ("survey.isel(x=slice(1))", "x, quality"),
        ("survey.assign_coords(y=survey.y + 1.0)", "y"),
        ("survey['no_such_variable']", "KeyError"),
    ],
)
def test_a_step_that_does_not_keep_the_survey_is_an_error(site, sample, body, shown):
    step = own_step(site, f"def own(survey): return {body}\n")
    with raises_fault(errors.STEPS, shown):
        apply_steps(sample, [step], never)


def test_simulated_data_stay_marked_whatever_a_step_does(site, sample):
    code = "def own(survey):\n    new = survey.copy()\n    new.attrs = {'simulated': 0}\n"
    step = own_step(site, code + "    return new\n")
    result = apply_steps(sample, [step], never)
    assert result.attrs["simulated"] == sample.attrs["simulated"] == 1
