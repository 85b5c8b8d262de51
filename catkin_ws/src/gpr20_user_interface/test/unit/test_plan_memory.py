"""The plan and the profiles on the disk, and the name of the next survey."""

import os

import pytest
from fault_kit import raises_fault

from gpr20_operator import faults
from gpr20_operator.errors import ProfileError, SettingsError
from gpr20_operator.files.settings_file import MAX_BYTES, SettingsFile
from gpr20_operator.plan.annotation import NextAnnotation, first_name, next_name
from gpr20_operator.plan.fields import default_parameters
from gpr20_operator.plan.memory import PlanMemory, RememberedPlan, plan_from, values_of
from gpr20_operator.plan.profiles import Profiles
from gpr20_survey.plan.annotation import Annotation

PLAN = RememberedPlan(
    texts={"vna_address": "10.0.0.2", "x_stop_mm": "350", "permittivity": "8"},
    following=frozenset("y"),
    arrow_step=10,
    annotation=Annotation("Ana Peña", "El Carmen", name="El Carmen 3"),
    last_area={"x_start_mm": "0", "x_stop_mm": "300"},
    configured_address="10.0.0.1",
)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gpr20" / "plan.yaml"


def memory(path, failures=None):
    return PlanMemory(SettingsFile(path), [].append if failures is None else failures.append)


def test_a_plan_is_there_after_a_restart_or_its_loss_is_reported(path):
    failures = []
    first = memory(path, failures)
    assert first.load() == RememberedPlan()
    first.save(PLAN)
    assert first.wait(30.0) and not failures
    assert memory(path).load() == PLAN
    broken = memory(path / "no folder", failures)
    broken.save(PLAN)
    assert broken.wait(30.0)
    assert failures[0].reason.fault_code == faults.SETTINGS_NOT_STORED.code


def test_a_damaged_plan_gives_the_defaults_and_says_so(path):
    for changes in (
        *({"fields": one} for one in (None, {"unknown": "1"}, {"x_points": 5})),
        *({"points_follow_spacing": one} for one in ("z", ["x"])),
        *({"arrow_step": one} for one in (7, True, [1])),
        *({"survey": one} for one in ({"notes": "x"}, {"operator": "a\nb"})),
        {"last_area": {"x_points": "5"}},
        {"configured_address": None},
    ):
        SettingsFile(path).write({**values_of(PLAN), **changes})
        damaged = memory(path)
        assert damaged.load() == RememberedPlan(), changes
        assert damaged.problem.fault_code == faults.SETTINGS_DAMAGED.code
    for key in values_of(PLAN):
        values = {name: value for name, value in values_of(PLAN).items() if name != key}
        with pytest.raises(SettingsError):
            plan_from(values)


def test_the_next_survey_gets_the_next_name():
    for name, after in (
        *(("", ""), ("El Carmen 3", "El Carmen 4"), ("P-009", "P-010"), ("99", "100")),
        *(("road", "road 2"), ("a" * 200, "a" * 198 + " 2"), ("a" * 199 + "9", "a" * 198 + "10")),
    ):
        assert next_name(name) == after


def test_a_survey_is_named_after_its_site_and_numbered():
    following = NextAnnotation()
    following.take_defaults(Annotation(site="El Carmen"))
    assert following.value.name == first_name("El Carmen") == "El Carmen 1"
    following.note_started()
    assert following.value.name == "El Carmen 2"
    following.take(Annotation(site="El Carmen", name="lane 7"))
    following.note_started()
    assert following.value == Annotation(site="El Carmen", name="lane 8")
    # The operator wants no name.
    following.take(Annotation(site="El Carmen"))
    following.note_started()
    assert following.value.name == ""


@pytest.fixture
def profiles(tmp_path):
    return Profiles(tmp_path)


def test_profile_is_loaded_as_it_was_saved_and_gone_when_it_was_removed(profiles, tmp_path):
    for _ in range(2):
        profiles.save("field 1", default_parameters())
    assert os.listdir(str(tmp_path)) == ["field 1.yaml"]
    assert profiles.names() == ["field 1"]
    assert profiles.load("field 1") == default_parameters()
    profiles.remove("field 1")
    assert profiles.names() == []
    with raises_fault(faults.PROFILE_NOT_STORED, "field 1.yaml"):
        profiles.remove("field 1")


def test_name_that_could_leave_the_folder_or_confuse_is_refused(profiles):
    for name in ("", " a", "a ", "../a", "a.b", ".a", "-a", "ä", "a\n", "a" * 33, "a\0"):
        for act in (profiles.load, profiles.remove):
            with raises_fault(faults.PROFILE_NAME, repr(name)):
                act(name)
        with raises_fault(faults.PROFILE_NAME, repr(name)):
            profiles.save(name, default_parameters())


def test_file_that_is_no_profile_is_refused_with_its_fault(profiles, tmp_path):
    profiles.save("a", default_parameters())
    path = tmp_path / "a.yaml"
    other_type = path.read_text().replace("x_points: 11", "x_points: eleven")
    for text, shown in (
        *((text, "a.yaml") for text in ("", "[1, 2]", "{a: 1}", "a: [", "[" * 60_000, "\x00")),
        ("vna_address: 10.0.0.1", "start_frequency_hz"),
        ("!!python/object/apply:os.system ['true']", "a.yaml"),
        ("x_points: 2026-13-45", "a.yaml"),
        ("#" * (MAX_BYTES + 1), MAX_BYTES),
        (other_type, "x_points"),
    ):
        path.write_text(text)
        with raises_fault(faults.PROFILE_UNREADABLE, shown, error=ProfileError):
            profiles.load("a")
