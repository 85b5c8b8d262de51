"""Steps of analysts: the tutorial docs/extend/processing_step.md, and what they may not do."""

import json
import re
import sys
import tempfile
from pathlib import Path

import pytest
import yaml
from command_kit import install
from fault_kit import raises_fault
from tutorial_code import code_blocks

from gpr20_analysis import faults
from gpr20_analysis.commands import main as gpr20
from gpr20_analysis.formats.dataset_files import read_dataset
from gpr20_analysis.processing.chain import (
    apply_steps,
    recipe_of,
    step_from_text,
    steps_from_recipe,
)
from gpr20_analysis.processing.step_functions import StepLibrary
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.sample.sample_survey import sample_survey

PAGE = Path(__file__).parents[6] / "docs/extend/processing_step.md"
NOTCH = "notch:center_hz=1.8e9"
ENTRY = "[gpr20_analysis.steps]\nnotch = my_steps:notch\n"

# The modules of the page, importable as those of an installed package are.
_folder = tempfile.TemporaryDirectory()
CODE = {**code_blocks(PAGE, "python"), **code_blocks(PAGE, "toml"), **code_blocks(PAGE, "yaml")}
for _name, _code in CODE.items():
    Path(_folder.name, _name).write_text(_code)
sys.path.insert(0, _folder.name)

from test_my_steps import *  # noqa: E402, F403


@pytest.fixture
def installed(tmp_path, monkeypatch):
    install(tmp_path / "site", ENTRY, "my-steps")
    monkeypatch.syspath_prepend(tmp_path / "site")
    return tmp_path / "site"


@pytest.fixture
def sample():
    return load_survey(sample_survey())


def never(path):
    raise AssertionError(path)


def test_the_commands_of_the_page_record_the_step_and_where_it_is_from(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_steps.py").write_text(CODE["my_steps.py"])
    commands = re.findall(r"^gpr20 (.*--steps-from.*)$", PAGE.read_text(), re.M)
    assert gpr20.main(["sample", "survey.mcap"]) == 0
    for command in commands:
        assert gpr20.main(command.split()) == 0
    recorded = recipe_of(read_dataset(tmp_path / "cleaned.nc"))
    assert recorded[0]["step"] == "notch" and recorded[0]["width_hz"] == 100e6
    assert re.fullmatch(r"my_steps.py, sha256 [0-9a-f]{16}", recorded[0]["origin"])


def test_a_recipe_names_an_installed_step(installed, sample):
    steps = steps_from_recipe(yaml.safe_load(CODE["recipe.yaml"]))
    result = apply_steps(sample, steps, never)
    notch, background = recipe_of(result)
    assert re.fullmatch(r"my-steps 1.0, my_steps:notch, sha256 [0-9a-f]{16}", notch["origin"])
    assert "origin" not in background
    # What is recorded is a recipe, and makes the same again.
    again = apply_steps(sample, steps_from_recipe(json.loads(result.attrs["processing"])), never)
    assert again.identical(result)


def test_the_entry_point_is_that_of_the_page():
    assert re.search(r'steps"\]\nnotch = "my_steps:notch"', CODE["pyproject.toml"])


def test_a_recipe_of_another_version_of_a_step_is_refused(installed):
    recipe = [{"step": "notch", "center_hz": 1e9, "origin": "my-steps 0.9, my_steps:notch"}]
    with raises_fault(faults.STEP_VERSION, "my-steps 0.9", "my-steps 1.0"):
        steps_from_recipe(recipe)


def test_a_step_that_is_not_installed_is_unknown_and_nothing_is_imported():
    for name in ("notch", "my_steps:notch", "os:system", "my_steps.notch"):
        with raises_fault(faults.RECIPE):
            steps_from_recipe([{"step": name, "center_hz": 1e9}])


def test_the_steps_that_exist_are_listed_with_those_installed(installed):
    with raises_fault(faults.RECIPE):
        step_from_text("no_such_step")


def test_no_step_replaces_another(installed, tmp_path):
    install(installed, "[gpr20_analysis.steps]\nnotch = other:notch\n", "other")
    with raises_fault(faults.OWN_STEP, "my-steps 1.0, my_steps:notch", "other 1.0, other:notch"):
        step_from_text(NOTCH)
    own = tmp_path / "own.py"
    own.write_text("def background(survey): return survey")
    with raises_fault(faults.OWN_STEP):
        StepLibrary(own)


def test_a_step_that_cannot_be_used_is_refused_with_the_reason(tmp_path):
    for number, (code, text, shown) in enumerate(
        (
            ("1 / 0", "own", "ZeroDivisionError"),
            ("def own(survey, width): return survey", "own:width=1", "width"),
            ("def own(survey, names: list): return survey", "own:names=1", "names"),
        )
    ):
        path = tmp_path / f"own{number}.py"
        path.write_text(code)
        with raises_fault(faults.OWN_STEP, shown):
            step_from_text(text, StepLibrary(path))


def test_a_step_that_does_not_keep_the_survey_is_an_error(tmp_path, sample):
    for number, (body, shown) in enumerate(
        (
            ("return None", "NoneType"),
            ("return survey.isel(x=slice(1))", "x, quality"),
            ("return survey.assign(s21=survey.s21.mean('frequency'))", "s21"),
            ("return survey.assign_coords(y=survey.y + 1.0)", "y"),
            ("return survey['no_such_variable']", "KeyError"),
        )
    ):
        path = tmp_path / f"own{number}.py"
        path.write_text(f"def own(survey):\n    {body}\n")
        step = step_from_text("own", StepLibrary(path))
        with raises_fault(faults.OWN_STEP, shown):
            apply_steps(sample, [step], never)


def test_simulated_data_stay_marked_whatever_a_step_does(tmp_path, sample):
    path = tmp_path / "own.py"
    path.write_text(
        "def own(survey):\n"
        "    new = survey.copy()\n"
        "    new.attrs = {'simulated': 0}\n"
        "    return new\n"
    )
    result = apply_steps(sample, [step_from_text("own", StepLibrary(path))], never)
    assert result.attrs["simulated"] == sample.attrs["simulated"] == 1
    assert result.attrs["survey_id"] == sample.attrs["survey_id"]
