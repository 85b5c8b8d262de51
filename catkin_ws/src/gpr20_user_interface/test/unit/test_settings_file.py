"""Files of a screen, the plan that it remembers, and the names of the surveys that follow."""

import os
import random
import threading

import pytest
from fault_kit import raises_fault
from run_seed import draws
from topics_kit import LIMIT_S

from gpr20_common.faults import DISK_REFUSES
from gpr20_common.mid.codec import plain
from gpr20_operator import faults
from gpr20_operator.errors import SettingsError
from gpr20_survey.plan.annotation import Annotation, Wgs84Position
from gpr20_user_interface.low.settings_file import (
    MAX_BYTES,
    Newest,
    PlanMemory,
    RememberedPlan,
    SettingsFile,
)
from gpr20_user_interface.pages.plan import NextAnnotation, next_name


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gpr20" / "window.yaml"


def test_values_are_read_as_they_were_written(path):
    assert SettingsFile(path).read() == {}
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
        with raises_fault(faults.SETTINGS_LOST.as_warning(), "window.yaml"):
            SettingsFile(path).read()
    path.unlink()
    path.mkdir()
    with raises_fault(faults.SETTINGS_LOST.as_warning(), "window.yaml"):
        SettingsFile(path).read()
    # Nor does random damage raise anything else.
    path.rmdir()
    draw = random.Random(7)
    SettingsFile(path).write({"vna_address": "10.0.0.2", "list": [1, 2.5], "deep": {"a": "ñ"}})
    whole = path.read_bytes()
    for _ in range(draws(75)):
        damaged = bytearray(whole)
        for _ in range(draw.randint(1, 6)):
            damaged[draw.randrange(len(damaged))] = draw.randrange(256)
        path.write_bytes(bytes(damaged[: draw.randint(0, len(damaged))]))
        try:
            assert isinstance(SettingsFile(path).read(), dict)
        except SettingsError as error:
            assert str(path) in str(error)


PLAN = RememberedPlan(
    texts={"vna_address": "10.0.0.2", "x_stop_mm": "350", "permittivity": "8"},
    annotation=Annotation("Ana Peña", "El Carmen", name="El Carmen 3"),
)


def plan_memory(path, failures=None):
    return PlanMemory(SettingsFile(path), [].append if failures is None else failures.append)


def test_a_plan_is_there_after_a_restart_or_its_loss_is_reported(path):
    failures = []
    first = plan_memory(path, failures)
    assert first.load() == RememberedPlan()
    first.save(PLAN)
    assert first.wait(30.0) and not failures
    assert plan_memory(path).load() == PLAN
    broken = plan_memory(path / "no folder", failures)
    broken.save(PLAN)
    assert broken.wait(30.0)
    assert failures[0].reason.fault_code == DISK_REFUSES.code


def test_a_damaged_plan_gives_the_defaults_and_says_so(path):
    for changes in (
        *({"texts": one} for one in (None, {"unknown": "1"}, {"x_points": 5})),
        *({"annotation": one} for one in ({"note": "x"}, {"operator": "a\nb"})),
    ):
        SettingsFile(path).write({**plain(PLAN), **changes})
        damaged = plan_memory(path)
        assert damaged.load() == RememberedPlan(), changes
        assert damaged.problem.fault_code == faults.SETTINGS_LOST.as_warning().code


def test_the_name_is_counted_up_and_notes_and_position_are_for_one_survey():
    for name, after in (
        *(("", ""), ("El Carmen 3", "El Carmen 4"), ("P-009", "P-010"), ("99", "100")),
        *(("road", "road 2"), ("a" * 200, "a" * 198 + " 2"), ("a" * 199 + "9", "a" * 198 + "10")),
    ):
        assert next_name(name) == after
    following = NextAnnotation()
    following.value = Annotation(
        "Ana", name="lane 7", notes="wet", position=Wgs84Position(4.6, -74)
    )
    following.take_defaults(Annotation("Eva", "El Carmen"))
    following.note_started()
    assert following.value == Annotation("Ana", "El Carmen", name="lane 8")


def test_the_newest_value_is_taken_next_even_after_one_that_failed(fault_log):
    taken, begun, go_on = [], threading.Event(), threading.Event()

    def act(value):
        taken.append(value)
        begun.set()
        assert go_on.wait(LIMIT_S)
        raise ZeroDivisionError("a fault of our own")

    newest = Newest(act)
    newest.put(1)
    assert begun.wait(LIMIT_S)
    for value in (2, 3):
        newest.put(value)
    go_on.set()
    assert newest.wait(LIMIT_S)
    assert (taken, len(fault_log)) == ([1, 3], 2)
