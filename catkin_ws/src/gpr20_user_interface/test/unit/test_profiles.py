import os
from pathlib import Path

import pytest
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_operator import faults
from gpr20_operator.errors import ProfileError
from gpr20_operator.files.settings_file import MAX_BYTES
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.profiles import Profiles


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "profiles"


@pytest.fixture
def profiles(folder):
    return Profiles(folder)


def test_profile_is_loaded_as_it_was_saved_and_gone_when_it_was_removed(profiles, folder):
    assert profiles.names() == []
    for _ in range(2):
        profiles.save("field 1", default_parameters())
    assert os.listdir(str(folder)) == ["field 1.yaml"]
    assert profiles.names() == ["field 1"]
    assert profiles.load("field 1") == default_parameters()
    profiles.remove("field 1")
    assert profiles.names() == []
    with raises_fault(faults.PROFILE_NOT_STORED, "field 1.yaml"):
        profiles.remove("field 1")
    with raises_fault(faults.PROFILE_UNREADABLE, "field 1.yaml"):
        profiles.load("field 1")


def test_name_that_could_leave_the_folder_or_confuse_is_refused(profiles):
    def save(name):
        profiles.save(name, default_parameters())

    names = ["", " a", "a ", "../a", "a/b", "a.b", ".a", "-a", "ä", "a\n", "a" * 33, "a\0"]
    for name in names:
        for act in (profiles.load, profiles.remove, save):
            with raises_fault(faults.PROFILE_NAME, repr(name)):
                act(name)


@given(st.text(max_size=40))
def test_a_name_that_is_allowed_is_one_part_of_a_path(name):
    try:
        path = Profiles(Path("/folder")).path(name)
    except ProfileError:
        return
    assert path.parent == Path("/folder") and os.path.basename(f"{name}.yaml") == path.name


def test_file_that_is_no_profile_is_refused_with_its_fault(profiles, folder):
    profiles.save("a", default_parameters())
    path = folder / "a.yaml"
    other_type = path.read_text().replace("x_points: 11", "x_points: eleven")
    for text, shown in (
        ("", "a.yaml"),
        ("[1, 2]", "a.yaml"),
        ("{a: 1}", "a.yaml"),
        ("vna_address: 10.0.0.1", "start_frequency_hz"),
        ("!!python/object/apply:os.system ['true']", "a.yaml"),
        ("a: [", "a.yaml"),
        ("[" * 60_000, "a.yaml"),
        ("x_points: 2026-13-45", "a.yaml"),
        ("\x00", "a.yaml"),
        ("#" * (MAX_BYTES + 1), MAX_BYTES),
        (other_type, "x_points"),
    ):
        path.write_text(text)
        with raises_fault(faults.PROFILE_UNREADABLE, shown, error=ProfileError):
            profiles.load("a")


def test_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    profiles = Profiles(tmp_path / "file" / "profiles")
    with raises_fault(faults.PROFILE_NOT_STORED, "a.yaml"):
        profiles.save("a", default_parameters())


def test_what_is_no_file_or_has_another_name_is_not_listed(profiles, folder):
    folder.mkdir()
    (folder / "a.b.yaml").write_text("")
    (folder / "a.txt").write_text("")
    (folder / "a.yaml").mkdir()
    os.mkfifo(str(folder / "b.yaml"))
    assert profiles.names() == []
