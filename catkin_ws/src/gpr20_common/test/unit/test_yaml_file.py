"""YAML files: what is in them, or one kind of error."""

from __future__ import annotations

import math

import pytest
import yaml
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults
from gpr20_common.low.yaml_file import MAX_BYTES, YamlFileError, read_yaml

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("yaml") / "a.yaml"


@given(PLAIN)
def test_what_was_written_is_read(path, values):
    path.write_text(yaml.safe_dump(values), encoding="utf-8")
    assert read_yaml(path) == values


@given(st.binary(max_size=60) | st.text("[]{}&*!:-?,#\"'|> \n0123456789abx_.").map(str.encode))
def test_any_bytes_are_read_or_refused_with_our_error(path, content):
    path.write_bytes(content)
    try:
        read_yaml(path)
    except YamlFileError as error:
        assert error.message.fault == faults.FILE_DAMAGED


@each_case(
    "text",
    [
        "!!python/object/apply:os.system ['touch outside']",
        "when: 2026-13-45",
        "number: 0x_",
        "[" * 60_000,
        "a: " + "[" * 500 + "]" * 500,
        "#" * (MAX_BYTES + 1),
        "a: [",
        "\x00",
    ],
)
def test_what_is_no_file_of_ours_is_refused(path, text):
    path.write_text(text)
    with raises_fault(faults.FILE_DAMAGED, error=YamlFileError):
        read_yaml(path)


def test_not_a_number_and_a_deep_file_are_read_and_a_missing_one_is_an_error(path):
    path.write_text("[.nan, " + "[" * 31 + "]" * 31 + "]")
    assert math.isnan(read_yaml(path)[0])
    with pytest.raises(FileNotFoundError):
        read_yaml(path.with_name("missing.yaml"))
