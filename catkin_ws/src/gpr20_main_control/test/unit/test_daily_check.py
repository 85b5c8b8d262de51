"""The daily check over a fake analyzer, its verdict, and the history that it makes."""

from __future__ import annotations

import json

import numpy as np
import pytest
from case_kit import each_case
from fake_robot import FakeAnalyzer
from fault_kit import raises_fault

from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.mid.daily_check import HISTORY, check_figures, judge
from gpr20_main_control.mid.devices.robot import UnconfirmedSweep
from gpr20_survey.faults import CHECK_ORDER
from gpr20_survey.results.answers import Part
from gpr20_survey.trace.sweep import AnalyzerSettings, Sweep

SWEPT_US = 1_800_000_000_000_000
HZ = np.linspace(600.0e6, 6.0e9, 501)
NOISE = 1e-5
ECHOES = {Part.EMPTY: (0.0, 1e-9), Part.PLATE: (0.02, 3e-9), Part.REFLECTOR: (0.005, 4.5e-9)}


def sweep_of(echo, random, gain=1.0, noise=NOISE, settings=None):
    """Return a sweep of a coupling and an echo."""
    s21 = sum(
        level * np.exp(-2j * np.pi * HZ * delay_s) for level, delay_s in ((0.05, 8e-10), echo)
    )
    s21 = gain * s21 + noise * random.standard_normal(501)
    settings = settings or AnalyzerSettings()
    return Sweep(HZ, s21.real, s21.imag, SWEPT_US, SWEPT_US, (), settings)


def figures(seed=1, gain=1.0, noise=NOISE, **echoes):
    """Return the figures of a check; `echoes` are level and delay at parts, by their names."""
    random = np.random.default_rng(seed)
    seen = {part: echoes.get(part.value, echo) for part, echo in ECHOES.items()}
    pairs = {
        part: tuple(sweep_of(echo, random, gain, noise) for _ in range(2))
        for part, echo in seen.items()
    }
    return check_figures(pairs)


@each_case("level, delay_ns", [(0.001, 1.23456), (0.5, 8.1)])
def test_the_figures_of_a_check_are_those_of_its_sweeps(level, delay_ns):
    found = figures(plate=(level, delay_ns * 1e-9))
    assert found[Part.PLATE]["delay_ns"] == pytest.approx(delay_ns, abs=0.006)
    assert found[Part.PLATE]["echo_db"] == pytest.approx(20.0 * np.log10(level), abs=0.05)
    empty = found[Part.EMPTY]
    assert empty["level_db"] == pytest.approx(20.0 * np.log10(0.05), abs=0.01)
    assert empty["noise_db"] == pytest.approx(20.0 * np.log10(NOISE / 0.05), abs=1.0)
    assert "echo_db" not in empty


HISTORY_OF_7 = [figures(seed) for seed in range(2, 9)]


@each_case(
    "changes, words",
    [
        ({}, "agrees with the median of the checks before (7)"),
        ({"gain": 0.8}, "-1.94 dB"),
        ({"plate": (0.02, 3.25e-9)}, "metal plate, delay of the echo: differs by +0.25 ns"),
        ({"noise": 1e-4}, "noise: differs by +"),
        # Less noise is no fault.
        ({"noise": 1e-7}, "agrees"),
        ({"plate": (0.0, 3e-9)}, "No echo of the metal plate"),
    ],
)
def test_the_verdict_names_what_differs_most_and_what_to_check(changes, words):
    verdict = judge(figures(seed=99, **changes), HISTORY_OF_7)
    assert verdict.good is ("agree" in words)
    assert words in str(verdict.message)
    assert verdict.good or "check" in str(verdict.message)


class SeeingAnalyzer(FakeAnalyzer):
    """Sees what was put below the antennas."""

    seen, gain = Part.EMPTY, 1.0

    def sweep(self):
        number = super().sweep().number
        random = np.random.default_rng(number)
        settings = self.settings.analyzer
        sweep = sweep_of(ECHOES[self.seen], random, self.gain, settings=settings)
        return UnconfirmedSweep(number, sweep)


@pytest.fixture
def stepped(make_bench, monkeypatch, tmp_path):
    """A main control whose analyzer sees what a step asks for."""
    monkeypatch.setenv("GPR20_DATA", str(tmp_path))
    return make_bench(analyzer=SeeingAnalyzer())


def step(bench, number):
    bench.analyzer.seen = list(Part)[number]
    return bench.control.daily_check(number)


def checked(bench, gain=1.0):
    bench.analyzer.gain = gain
    *others, verdict = [step(bench, number) for number in range(3)]
    assert others == [None, None]
    return verdict


def history(folder):
    return [json.loads(one) for one in (folder / HISTORY).read_text().splitlines()]


def test_the_parts_of_other_checks_or_clients_do_not_make_one_check(stepped):
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
    refused(2, "/other")
    stepped.analyzer.identity = "Anritsu,MS2026C,other"
    refused(1, "/other")


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


def test_checks_are_compared_with_the_good_ones_before_of_the_same_robot(stepped, tmp_path):
    verdict = checked(stepped)
    assert verdict.good and "first check" in str(verdict.message)
    # The release is not waited for.
    stepped.robot.analyzer_calls.call(lambda: None, lambda: None)
    assert (stepped.analyzer.sweeps, stepped.analyzer.releases) == (6, 3)
    assert stepped.activities[0] is not None and stepped.activities[-1] is None
    assert "checks before (1)" in str(checked(stepped).message)
    # A check that differs is kept, and nothing is compared with it.
    for _ in range(2):
        differs = checked(stepped, gain=0.7)
        assert not differs.good and "checks before (2)" in str(differs.message)
    assert checked(stepped).good
    lines = history(tmp_path)
    assert {(one["robot"], one["simulated"]) for one in lines} == {("GPR-20", True)}
    for key, value in (("robot", "other"), ("simulated", False)):
        others = "".join(json.dumps({**one, key: value}) + "\n" for one in lines)
        (tmp_path / HISTORY).write_text(others)
        assert "first check" in str(checked(stepped, gain=0.7).message)
    assert [one["good"] for one in lines] == [True, True, False, False, True]
    assert {one["identity"] for one in lines} == {stepped.analyzer.identity}
