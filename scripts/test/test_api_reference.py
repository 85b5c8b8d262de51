"""The reference of the public interface is built without warnings, and leaves nothing out."""

from __future__ import annotations

import dataclasses
import enum
import inspect
import re

import api_reference
import pytest

import gpr20_analysis

PUBLIC = {name: getattr(gpr20_analysis, name) for name in gpr20_analysis.__all__}
FUNCTIONS = {name: one for name, one in PUBLIC.items() if inspect.isfunction(one)}
RECORDS = {name: one for name, one in PUBLIC.items() if dataclasses.is_dataclass(one)}
# Functions that cannot fail, or only as their arguments say.
NEVER_RAISE = {
    *("candidate_lines", "message_of", "permittivity_line", "sample_survey", "summarize"),
    *("cell_text", "survey_remarks"),
}


def section(docstring: str, title: str) -> str:
    found = re.search(rf"^{title}:\n((?:[ ]+.*\n?|\n)+)", docstring, re.MULTILINE)
    return found[1] if found else ""


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> str:
    folder = tmp_path_factory.mktemp("reference")
    return api_reference.build(folder).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", PUBLIC)
def test_every_public_name_is_in_the_reference(page, name):
    assert f'id="{name}"' in page


def test_no_part_of_the_package_below_is_in_it(page):
    assert "gpr20_analysis.commands" not in page


@pytest.mark.parametrize("name", FUNCTIONS)
def test_each_function_describes_arguments_result_and_errors(name):
    function = FUNCTIONS[name]
    docstring = inspect.getdoc(function) or ""
    described = re.findall(r"^ {4}(\w+):", section(docstring, "Args"), re.MULTILINE)
    parameters = [one.lstrip("*") for one in inspect.signature(function).parameters]
    assert described[: len(parameters)] == parameters
    if inspect.signature(function).return_annotation not in ("None", None):
        assert section(docstring, "Returns")
    assert section(docstring, "Raises") or name in NEVER_RAISE


@pytest.mark.parametrize("name", RECORDS)
def test_each_record_describes_its_fields(name):
    docstring = inspect.getdoc(RECORDS[name]) or ""
    described = re.findall(r"^ {4}(\w+):", section(docstring, "Attributes"), re.MULTILINE)
    described += re.findall(
        r"^ +(\w+): .*\n +\"{3}", inspect.getsource(RECORDS[name]), re.MULTILINE
    )
    assert set(described) >= {one.name for one in dataclasses.fields(RECORDS[name])}


@pytest.mark.parametrize(
    "name",
    sorted(name for name, one in PUBLIC.items() if inspect.isclass(one) and name not in RECORDS),
)
def test_every_other_name_is_described(name):
    one = PUBLIC[name]
    assert inspect.getdoc(one)
    if issubclass(one, enum.Enum):
        assert one.__doc__ != enum.Enum.__doc__
