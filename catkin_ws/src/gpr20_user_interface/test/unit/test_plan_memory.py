import random
import threading

import pytest
import yaml
from view_kit import TRAVEL as ROBOT

from gpr20_operator import faults
from gpr20_operator.errors import SettingsError
from gpr20_operator.files.settings_file import SettingsFile
from gpr20_operator.plan.annotation import NextAnnotation, first_name, next_name
from gpr20_operator.plan.form import PlanForm
from gpr20_operator.plan.memory import PlanMemory, RememberedPlan, plan_from, values_of
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


def test_a_plan_is_there_after_a_restart(path):
    first = memory(path)
    assert first.load() == RememberedPlan()
    first.save(PLAN)
    assert first.wait(10.0)
    second = memory(path)
    assert second.load() == PLAN
    assert second.problem is None


def test_only_the_newest_plan_counts_and_nothing_is_written_twice(path):
    written = []
    begun, go_on = threading.Event(), threading.Event()

    class Slow:
        def read(self):
            return {}

        def write(self, values):
            begun.set()
            go_on.wait(10.0)
            written.append(values["arrow_step"])

    slow = PlanMemory(Slow(), written.append)
    slow.load()
    slow.save(RememberedPlan(arrow_step=10))
    assert begun.wait(10.0)
    for step in (1, 10, 100):
        slow.save(RememberedPlan(arrow_step=step))
    go_on.set()
    assert slow.wait(10.0)
    slow.save(RememberedPlan(arrow_step=100))
    assert slow.wait(10.0)
    assert written == [10, 100]


def test_a_disk_that_refuses_is_reported(tmp_path):
    (tmp_path / "file").write_text("")
    failures = []
    broken = memory(tmp_path / "file" / "plan.yaml", failures)
    broken.save(PLAN)
    assert broken.wait(10.0)
    assert failures[0].reason.fault_code == faults.SETTINGS_NOT_STORED.code


def test_a_damaged_plan_gives_the_defaults_and_says_so(path):
    for changes in (
        {"fields": None},
        {"fields": {"unknown": "1"}},
        {"fields": {"x_points": 5}},
        {"fields": {"x_points": "5" * 300}},
        {"points_follow_spacing": "z"},
        {"points_follow_spacing": ["x"]},
        {"arrow_step": 7},
        {"arrow_step": True},
        {"arrow_step": [1]},
        {"survey": {"notes": "x"}},
        {"survey": {"operator": "a\nb"}},
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


def test_random_damage_is_never_a_crash(path):
    draw = random.Random(11)
    text = yaml.safe_dump(values_of(PLAN), allow_unicode=True)
    path.parent.mkdir()
    for _ in range(300):
        damaged = bytearray(text.encode())
        for _ in range(draw.randint(1, 4)):
            damaged[draw.randrange(len(damaged))] = draw.randrange(32, 127)
        path.write_bytes(bytes(damaged))
        plan = memory(path).load()
        form = PlanForm(ROBOT)
        form.restore(plan.texts, plan.following)
        form.check()


def test_the_next_survey_gets_the_next_name():
    for name, after in (
        ("", ""),
        ("El Carmen 3", "El Carmen 4"),
        ("P-009", "P-010"),
        ("99", "100"),
        ("road", "road 2"),
        ("a" * 200, "a" * 198 + " 2"),
        ("a" * 199 + "9", "a" * 198 + "10"),
        ("lane ٣", "lane ٣ 2"),
    ):
        assert next_name(name) == after
        assert Annotation(name=after).name == after


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
