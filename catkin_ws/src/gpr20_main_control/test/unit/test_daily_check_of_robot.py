"""The daily check over a fake analyzer, and the history that it makes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from fake_robot import FakeAnalyzer
from fault_kit import raises_fault

from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.mid.devices.robot import UnconfirmedSweep
from gpr20_main_control.mid.radar_check import CHECK_LIMIT_S, HISTORY
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.results.daily_check import Part
from gpr20_survey.trace.sweep import Sweep

SWEPT_US = 1_800_000_000_000_000
DELAYS_NS = {Part.EMPTY: None, Part.PLATE: 3.0, Part.REFLECTOR: 4.5}


class SeeingAnalyzer(FakeAnalyzer):
    """Sees what was put below the antennas."""

    seen, gain = Part.EMPTY, 1.0

    def sweep(self):
        number = super().sweep().number
        hz = self.settings.frequencies_hz()
        s21 = 0.05 * np.exp(-2j * np.pi * hz * 0.8e-9)
        if DELAYS_NS[self.seen]:
            s21 = s21 + 0.02 * np.exp(-2j * np.pi * hz * 1e-9 * DELAYS_NS[self.seen])
        random = np.random.default_rng(number)
        s21 = self.gain * s21 + 1e-5 * (random.standard_normal(501) + 0j)
        settings = self.settings.analyzer
        return UnconfirmedSweep(
            number, Sweep(hz, s21.real, s21.imag, SWEPT_US, SWEPT_US, (), settings)
        )


@pytest.fixture
def stepped(make_bench, monkeypatch, tmp_path):
    """A main control whose analyzer sees what a step asks for."""
    monkeypatch.setenv("GPR20_DATA", str(tmp_path))
    return make_bench(analyzer=SeeingAnalyzer())


def step(bench, number):
    bench.analyzer.seen = dict(enumerate(Part)).get(number)
    return bench.control.daily_check(number)


def test_three_steps_make_a_check_with_a_verdict_and_a_line_of_the_history(stepped, tmp_path):
    for _day in range(2):
        assert [step(stepped, number) for number in (0, 1)] == [None, None]
        verdict = step(stepped, 2)
        assert verdict.good
    assert "checks before (1)" in str(verdict.message)
    lines = [json.loads(one) for one in (tmp_path / HISTORY).read_text().splitlines()]
    assert [(one["robot"], one["simulated"]) for one in lines] == [("GPR-20", True)] * 2
    # The release is not waited for.
    stepped.robot.analyzer_calls.call(lambda: None, lambda: None)
    assert (stepped.analyzer.sweeps, stepped.analyzer.releases) == (12, 6)
    assert stepped.activities[0] is not None and stepped.activities[-1] is None


def test_the_parts_of_other_checks_clients_or_of_long_ago_do_not_make_one_check(
    stepped, monkeypatch
):
    def refused(number, client):
        sweeps = stepped.analyzer.sweeps
        with raises_fault(CHECK_ORDER, error=RequestRefusedError):
            stepped.control.daily_check(number, client)
        assert stepped.analyzer.sweeps == sweeps

    for number in (1, 2, 3, 255):
        refused(number, "/window")
    stepped.control.daily_check(0, "/window")
    refused(1, "/other")
    refused(2, "/window")
    stepped.control.daily_check(1, "/window")
    stepped.control.daily_check(0, "/other")
    refused(2, "/window")
    now_s = stepped.clock.now_s
    monkeypatch.setattr(stepped.clock, "now_s", lambda: now_s() + CHECK_LIMIT_S + 1.0)
    refused(1, "/other")
    stepped.control.daily_check(0, "/other")
    stepped.control.daily_check(1, "/other")


def test_a_step_that_failed_or_could_not_be_stored_can_be_repeated(stepped, tmp_path):
    step(stepped, 0)
    stepped.analyzer.failures = 1
    with pytest.raises(DeviceError):
        step(stepped, 1)
    step(stepped, 1)
    blocked = tmp_path / HISTORY.parent
    blocked.write_text("a file in place of the folder")
    with pytest.raises(DeviceError, match="could not be made"):
        step(stepped, 2)
    blocked.unlink()
    assert step(stepped, 2).good


def checked(bench, gain=1.0):
    bench.analyzer.gain = gain
    return [step(bench, number) for number in range(3)][-1]


def history(folder):
    return [json.loads(one) for one in (folder / HISTORY).read_text().splitlines()]


def test_an_analyzer_that_is_replaced_during_the_check_is_refused(stepped):
    step(stepped, 0)
    step(stepped, 1)
    stepped.analyzer.identity = "Anritsu,MS2026C,other"
    with raises_fault(CHECK_ORDER, error=RequestRefusedError):
        step(stepped, 2)


def test_checks_are_compared_with_the_good_ones_before_of_the_same_robot(stepped, tmp_path):
    verdict = checked(stepped)
    assert verdict.good and "first check" in str(verdict.message)
    assert "checks before (1)" in str(checked(stepped).message)
    # A check that differs is kept, and nothing is compared with it.
    for _ in range(2):
        differs = checked(stepped, gain=0.7)
        assert not differs.good and "checks before (2)" in str(differs.message)
    assert checked(stepped).good
    lines = history(tmp_path)
    for key, value in (("robot", "other"), ("simulated", False)):
        others = "".join(json.dumps({**one, key: value}) + "\n" for one in lines)
        (tmp_path / HISTORY).write_text(others)
        assert "first check" in str(checked(stepped, gain=0.7).message)
    assert [one["good"] for one in lines] == [True, True, False, False, True]
    assert {one["identity"] for one in lines} == {stepped.analyzer.identity}


def test_lines_that_cannot_be_read_are_counted_and_left_alone(stepped, tmp_path):
    checked(stepped)
    path = tmp_path / HISTORY
    line = json.loads(path.read_text())
    odd = [{**line, "figures": 7}, {**line, "figures": {"sky": {}}}]
    text = path.read_text() + "".join(json.dumps(one) + "\n" for one in odd) + "{\n"
    path.write_text(text)
    verdict = checked(stepped)
    assert verdict.good and "3 lines" in verdict.message.details
    assert path.read_text().startswith(text)
