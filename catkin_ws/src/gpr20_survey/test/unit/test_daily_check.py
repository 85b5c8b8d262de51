"""The daily check: figures of known echoes, and the verdict against the checks before."""

from __future__ import annotations

import numpy as np
import pytest
from case_kit import each_case

from gpr20_survey.files.json_lines import add_line, read_lines
from gpr20_survey.results.daily_check import (
    Part,
    check_figures,
    figures_from,
    judge,
    recorded_figures,
)
from gpr20_survey.trace.sweep import Sweep
from gpr20_survey.trace.sweep_settings import AnalyzerSettings

HZ = np.linspace(600.0e6, 6.0e9, 501)
COUPLING = 0.05 * np.exp(-2j * np.pi * HZ * 0.8e-9)
NOISE = 1e-5
SWEPT_US = 1_800_000_000_000_000


def echo(level, delay_ns):
    return level * np.exp(-2j * np.pi * HZ * delay_ns * 1e-9)


def pair(s21, random, noise=NOISE):
    """Return two sweeps in a row, with noise."""
    sweeps = []
    for _ in range(2):
        hiss = noise * (random.standard_normal(501) + 1j * random.standard_normal(501))
        values = s21 + hiss
        sweeps.append(
            Sweep(HZ, values.real, values.imag, SWEPT_US, SWEPT_US, (), AnalyzerSettings())
        )
    return tuple(sweeps)


def figures(seed=1, gain=1.0, plate=(0.02, 3.0), reflector=(0.005, 4.5), noise=NOISE):
    random = np.random.default_rng(seed)
    return check_figures(
        {
            Part.EMPTY: pair(gain * COUPLING, random, noise),
            Part.PLATE: pair(gain * (COUPLING + echo(*plate)), random, noise),
            Part.REFLECTOR: pair(gain * (COUPLING + echo(*reflector)), random, noise),
        }
    )


@each_case("level, delay_ns", [(0.02, 3.0), (0.001, 1.23456), (0.5, 8.1), (0.0003, 14.0)])
def test_the_echo_of_the_plate_is_found_where_it_is(level, delay_ns):
    found = figures(plate=(level, delay_ns))[Part.PLATE]
    assert found["delay_ns"] == pytest.approx(delay_ns, abs=0.002)
    assert found["echo_db"] == pytest.approx(20.0 * np.log10(level), abs=0.05)


def test_level_and_noise_are_those_of_the_sweeps():
    found = figures()[Part.EMPTY]
    assert found["level_db"] == pytest.approx(20.0 * np.log10(0.05), abs=0.01)
    noise_db = 20.0 * np.log10(NOISE * np.sqrt(2.0) / 0.05)
    assert found["noise_db"] == pytest.approx(noise_db, abs=1.0)
    assert "echo_db" not in found


def test_the_first_check_begins_the_history():
    verdict = judge(figures(), [])
    assert verdict.good and "first check" in str(verdict.message)
    assert len(verdict.comparisons) == 10


HISTORY = [figures(seed) for seed in range(2, 9)]


@each_case(
    "changes, words",
    [
        ({}, "every figure agrees with the median of the checks before (7)"),
        ({"gain": 0.8}, "differs by -1.94 dB"),
        ({"plate": (0.02, 3.25)}, "metal plate, delay of the echo: differs by +0.25 ns"),
        ({"plate": (0.01, 3.0)}, "metal plate, level of the echo: differs by -6.02 dB"),
        ({"reflector": (0.005, 4.2)}, "known reflector, delay of the echo: differs by -0.30 ns"),
        ({"noise": 1e-4}, "noise: differs by +"),
        # Less noise is no fault.
        ({"noise": 1e-7}, "every figure agrees"),
        ({"plate": (0.0, 3.0)}, "No echo of the metal plate was found"),
        ({"reflector": (3e-6, 4.5)}, "No echo of the known reflector was found"),
    ],
)
def test_the_verdict_names_what_differs_most_and_what_to_check(changes, words):
    verdict = judge(figures(seed=99, **changes), HISTORY)
    assert verdict.good is ("agree" in words)
    assert words in str(verdict.message)
    assert verdict.good or "check" in str(verdict.message)


def test_an_analyzer_without_noise_has_no_figure_of_it():
    found = figures(noise=0.0)
    assert found[Part.EMPTY]["noise_db"] is None
    assert judge(found, [found, found]).good


def test_a_single_odd_check_does_not_move_what_is_usual():
    odd = figures(seed=3, plate=(0.05, 5.0))
    assert judge(figures(seed=4), [*HISTORY[:3], odd]).good


def test_stored_figures_are_read_as_they_were():
    assert figures_from(recorded_figures(figures())) == figures()
    for odd in ({"sky": {}}, {"empty": 7}, {"empty": {"level_db": "x"}}, {"empty": {"a": [1]}}):
        with pytest.raises(ValueError):
            figures_from(odd)


def test_a_line_that_a_crash_has_cut_damages_no_other(tmp_path):
    path = tmp_path / "checks" / "history.jsonl"
    assert read_lines(path) == ([], 0)
    add_line(path, {"a": 1})
    path.write_bytes(path.read_bytes() + b'{"b": ')
    add_line(path, {"c": "\u00f1\n"})
    assert read_lines(path) == ([{"a": 1}, {"c": "\u00f1\n"}], 1)
    with pytest.raises(ValueError):
        add_line(path, {"d": float("nan")})
    assert read_lines(path)[1] == 1
