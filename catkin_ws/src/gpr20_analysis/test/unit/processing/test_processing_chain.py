"""Chains of steps: how they are written, checked, applied and recorded."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from fault_kit import raises_fault
from ground_kit import point, scene, survey_of

from gpr20_analysis import faults
from gpr20_analysis.errors import RecipeError
from gpr20_analysis.formats.dataset_files import read_dataset, write_dataset
from gpr20_analysis.processing.chain import (
    apply_steps,
    read_recipe,
    recipe_of,
    recipe_text,
    step_from_text,
    steps_from_recipe,
)
from gpr20_analysis.processing.step_functions import FUNCTIONS

PAGE = Path(__file__).parents[6] / "docs/reference/imaging.md"
PLACES_MM = np.linspace(200.0, 280.0, 5)
SURVEY = survey_of(scene([point(243.7, 236.2, 0.083)]), PLACES_MM, PLACES_MM)


def never(path):
    raise AssertionError(f"no step names a survey, but {path} was read")


def test_a_chain_runs_in_its_order_and_is_recorded():
    texts = ["band:start_hz=1e9,stop_hz=5e9", "background:method=median", "time:padding=2"]
    result = apply_steps(SURVEY, [step_from_text(text) for text in texts], never)
    recorded = json.loads(result.attrs["processing"])
    assert [one["step"] for one in recorded] == ["band", "background", "time"]
    assert recorded[1] == {"step": "background", "method": "median", "width": 11, "rank": 1}


def test_the_recorded_recipe_repeats_the_result(tmp_path):
    texts = ["background:method=svd,rank=2", "time_zero", "combine:method=difference", "time"]
    first = apply_steps(SURVEY, [step_from_text(text) for text in texts], never)
    path = tmp_path / "recipe.yaml"
    path.write_text(recipe_text(recipe_of(first)))
    second = apply_steps(SURVEY, steps_from_recipe(read_recipe(path)), never)
    np.testing.assert_array_equal(first.a_scan.values, second.a_scan.values)
    assert recipe_of(first) == recipe_of(second)


def test_the_recipe_outlives_a_file(tmp_path):
    done = apply_steps(SURVEY, [step_from_text("background")], never)
    write_dataset(done, tmp_path / "done.nc")
    assert recipe_of(read_dataset(tmp_path / "done.nc")) == recipe_of(done)


def test_a_step_can_name_a_reference_survey(tmp_path):
    read = []

    def reader(path):
        read.append(path)
        return SURVEY

    steps = [step_from_text(f"coupling:reference={tmp_path}/sky.nc")]
    apply_steps(SURVEY, steps, reader)
    assert read == [f"{tmp_path}/sky.nc"]


NO_STEPS = (
    ("migrate", "background"),
    ("background:rang=2", "'rang'"),
    ("background:rank=two", "'two'"),
    ("background:rank=1.5", "'1.5'"),
    ("background:rank=inf", "'inf'"),
    ("time:padding=nan", "'nan'"),
    ("background:method=average", "median"),
    ("background:method", "'method'"),
    ("background:rank=1,rank=2", "'rank=2'"),
    ("band:start_hz=1e9", "'stop_hz'"),
    ("coupling", "'reference'"),
    ("", "background"),
)


def test_steps_that_make_no_sense_are_refused_with_what_is_allowed():
    for text, shown in NO_STEPS:
        with raises_fault(faults.RECIPE, shown):
            step_from_text(text)


def test_files_that_are_no_recipe_are_refused():
    for recipe in ("", "[]", "step: background", "- background", "- {rank: 1}"):
        with pytest.raises(RecipeError):
            steps_from_recipe(yaml.safe_load(recipe))


def test_a_file_that_is_no_yaml_is_refused(tmp_path):
    path = tmp_path / "recipe.yaml"
    path.write_text("- [")
    with raises_fault(faults.RECIPE, path):
        read_recipe(path)


def test_every_step_documents_itself():
    assert all(function.__doc__ for function in FUNCTIONS.values())


def test_the_page_on_imaging_lists_every_step():
    table = PAGE.read_text("utf-8").split("## Steps\n")[1].split("\n## ")[0]
    listed = set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE))
    different = listed ^ set(FUNCTIONS)
    assert not different, f"only in FUNCTIONS, or only in 'Steps' of {PAGE}: {different}"
