import os
import random

import pytest
from fault_kit import raises_fault

from gpr20_operator import faults
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import MAX_BYTES, SettingsFile


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gpr20" / "window.yaml"


def test_no_file_gives_no_values(path):
    assert SettingsFile(path).read() == {}


def test_values_are_read_as_they_were_written(path):
    values = {"site": "El Carmen, Peña: №1", "soil": 4.5, "list": [0.0, 90.0], "none": None}
    SettingsFile(path).write(values)
    assert SettingsFile(path).read() == values
    SettingsFile(path).write({"a": 1})
    assert SettingsFile(path).read() == {"a": 1}
    assert os.listdir(str(path.parent)) == ["window.yaml"]


def test_a_damaged_file_is_refused_with_its_name(path):
    path.parent.mkdir()
    for text in ("", "[1]", "{1: 2}", "a: [", "\x00", "#" * (MAX_BYTES + 1)):
        path.write_text(text)
        with raises_fault(faults.SETTINGS_DAMAGED, "window.yaml"):
            SettingsFile(path).read()


def test_random_damage_never_raises_anything_else(path):
    draw = random.Random(7)
    SettingsFile(path).write({"vna_address": "10.0.0.2", "list": [1, 2.5], "deep": {"a": "ñ"}})
    whole = path.read_bytes()
    for _ in range(300):
        damaged = bytearray(whole)
        for _ in range(draw.randint(1, 6)):
            damaged[draw.randrange(len(damaged))] = draw.randrange(256)
        path.write_bytes(bytes(damaged[: draw.randint(0, len(damaged))]))
        try:
            assert isinstance(SettingsFile(path).read(), dict)
        except SettingsError as error:
            assert str(path) in str(error)


def test_a_folder_or_a_pipe_is_refused(path):
    path.parent.mkdir()
    path.mkdir()
    with raises_fault(faults.SETTINGS_DAMAGED, "window.yaml"):
        SettingsFile(path).read()
    path.rmdir()
    os.mkfifo(str(path))
    with raises_fault(faults.SETTINGS_DAMAGED, "window.yaml"):
        SettingsFile(path).read()


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with raises_fault(faults.SETTINGS_NOT_STORED, "window.yaml"):
        SettingsFile(tmp_path / "file" / "window.yaml").write({"a": 1})
