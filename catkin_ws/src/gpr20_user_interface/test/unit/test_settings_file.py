"""Files of a screen: what it remembers is there after a restart, or its loss is said."""

import os
import random
import threading

import pytest
from run_seed import draws
from topics_kit import LIMIT_S

from gpr20_common.faults import DISK_REFUSES
from gpr20_common.mid.codec import plain
from gpr20_operator import faults
from gpr20_operator.palette import Theme
from gpr20_survey.plan.annotation import Annotation
from gpr20_user_interface.low.settings_file import Newest, PlanMemory, RememberedPlan, SettingsFile
from gpr20_user_interface.pages.settings import WindowMemory, WindowSettings

PLAN = RememberedPlan(
    texts={"vna_address": "10.0.0.2", "x_stop_mm": "350", "permittivity": "8"},
    annotation=Annotation("Ana Peña", "El Carmen", name="El Carmen 3"),
)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "gpr20" / "window.yaml"


def test_a_plan_is_there_after_a_restart_or_its_loss_is_reported(path):
    failures = []
    first = PlanMemory(SettingsFile(path), failures.append)
    assert first.load() == RememberedPlan()
    first.save(PLAN)
    assert first.wait(LIMIT_S) and not failures
    assert PlanMemory(SettingsFile(path), failures.append).load() == PLAN
    assert os.listdir(str(path.parent)) == ["window.yaml"]
    broken = PlanMemory(SettingsFile(path / "no folder"), failures.append)
    broken.save(PLAN)
    assert broken.wait(LIMIT_S)
    assert failures[0].reason.fault_code == DISK_REFUSES.code


def test_a_damaged_plan_gives_the_defaults_and_says_so(path):
    draw, damaged_plans = random.Random(7), 0
    SettingsFile(path).write(plain(PLAN))
    whole = path.read_bytes()
    for _ in range(draws(100)):
        damaged = bytearray(whole)
        for _ in range(draw.randint(1, 6)):
            damaged[draw.randrange(len(damaged))] = draw.randrange(256)
        path.write_bytes(bytes(damaged[: draw.randint(0, len(damaged))]))
        memory = PlanMemory(SettingsFile(path), None)
        plan = memory.load()
        if memory.problem is not None:
            damaged_plans += 1
            assert plan == RememberedPlan()
            assert memory.problem.fault_code == faults.SETTINGS_LOST.as_warning().code
    assert damaged_plans


def test_settings_that_cannot_be_written_hold_until_the_end_and_this_is_said(tmp_path):
    (tmp_path / "file").touch()
    problems = []
    memory = WindowMemory(SettingsFile(tmp_path / "file" / "window.yaml"), problems.append)
    # Neither can it be read: the defaults hold.
    assert memory.settings == WindowSettings() and len(problems) == 1
    memory.change(theme=Theme.NIGHT)
    assert memory.close(LIMIT_S)
    assert memory.settings.theme is Theme.NIGHT and len(problems) == 2


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
