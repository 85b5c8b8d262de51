"""The checks of analyzers pass a good class and catch each bad one."""

from __future__ import annotations

import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rospkg")

import toy_vna
from case_kit import each_case
from toy_vna import ADDRESS, MAKER, MODEL, ToyInstrument, ToyVna

from gpr20_common.low.clock import time_of_day_us
from gpr20_common.message import Message, verbatim
from gpr20_simulator.high.check_simulated_analyzer import CheckedSimulation
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions
from gpr20_simulator.mid.world.scene import read_scene
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.high import check_analyzer
from gpr20_vna_acquisition.mid.analyzer_record import (
    FILE,
    Result,
    Status,
    has_passed,
    passed,
    store,
)
from gpr20_vna_acquisition.mid.conformance import Bench, Extent, results
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

QUICK = Extent(21, (1e5, 1e4, 1e3), sweeps=4, watched_s=0.05, limit_s=60.0)
SCENE = Path(__file__).parents[3] / "gpr20_simulator/scenes/two_targets.yaml"


def parameters_of(name: str, instrument: ToyInstrument, **changed) -> VnaParameters:
    values = {
        "analyzer": f"{__name__}:{name}",
        "analyzer_options": {"instrument": instrument},
        "address": ADDRESS,
        "maker": MAKER,
        "model": MODEL,
        **changed,
    }
    return VnaParameters(**values)


def bench_of(name: str, extent: Extent = QUICK, **changed) -> Bench:
    instrument = ToyInstrument()
    return Bench(parameters_of(name, instrument, **changed), lambda _address: None, extent)


class Good(ToyVna):
    """As toy_vna has it."""


class PreviousSweep(ToyVna):
    """Gives what the display shows, and only then measures."""

    def sweep(self):
        self.check_link()
        shown = getattr(self.instrument, "shown", None)
        started_us = time_of_day_us()
        self.instrument.shown = self.instrument.sweep()
        return self.as_sweep(self.instrument.shown if shown is None else shown, started_us)


class LearnsAndIsLate(PreviousSweep):
    """Is one sweep late, which its sweeps at set-up hide from every other check."""

    def configure(self, settings: SweepSettings):
        accepted = super().configure(settings)
        self.sweep()
        self.sweep()
        return accepted


class ConfirmsAnything(ToyVna):
    """Does not read the settings again."""

    def confirm(self):
        self.check_link()
        if self.accepted is None:
            raise errors.not_configured()


class IgnoresSettings(ConfirmsAnything):
    """Reads back what it was asked for."""

    def configure(self, settings: SweepSettings):
        own, wanted = self.instrument.settings.analyzer, settings.analyzer
        bandwidth_hz = wanted.if_bandwidth_hz or own.if_bandwidth_hz
        analyzer = AnalyzerSettings(bandwidth_hz, wanted.averages or own.averages)
        self.accepted = replace(settings, analyzer=analyzer)
        return self.accepted

    def as_sweep(self, data, started_us):
        places, measured = (np.linspace(0, 1, one) for one in (self.accepted.points, len(data)))
        return super().as_sweep(np.interp(places, measured, data), started_us)


class OtherPoints(ToyVna):
    """Measures fewer points than asked for, and says so."""

    def configure(self, settings: SweepSettings):
        return super().configure(replace(settings, points=settings.points - 1))


class SwapsIdentity(ToyVna):
    """Another serial number on each link."""

    def identify(self):
        super().identify()
        return f"{MAKER},{MODEL},{len(self.instrument.made)},1.0"


class AcceptsAnybody(ToyVna):
    """Does not compare the identity."""

    def identify(self):
        return self.instrument.identity


class Spoils(ToyVna):
    """Gives something else than it measured."""

    def __init__(self, parameters, deadline, instrument, spoil):
        super().__init__(parameters, deadline, instrument)
        self.spoil, self.former = spoil, np.array([])

    def as_sweep(self, data, started_us):
        former, self.former = self.former, data
        if len(former) == len(data):
            data = self.spoil(former, data)
        return super().as_sweep(data, started_us)


class MeasuredBefore(ToyVna):
    """Says when it really measured: before the request."""

    def as_sweep(self, data, started_us):
        return super().as_sweep(data, started_us - 10_000_000)


class NeedsNoLink(ToyVna):
    """Gives data whatever became of the link."""

    def check_link(self):
        self.deadline.check()


def failures(name: str, **changed):
    """Yield the checks that fail."""
    bench = bench_of(name, **changed)
    return (one.check for one in results(bench) if one.status is Status.FAILED)


def test_a_good_class_passes_and_what_needs_its_messages_is_not_tested():
    found = list(results(bench_of("Good")))
    assert passed(found), found
    statuses = {one.check: one.status for one in found}
    assert statuses["sweep_end"] is statuses["by_hand"] is Status.NOT_TESTED
    assert statuses["first_sweep"] is statuses["sweep_times"] is Status.PASSED


@each_case(
    "name, check",
    [
        ("PreviousSweep", "first_sweep"),
        ("IgnoresSettings", "sweep_times"),
        ("IgnoresSettings", "reconnection"),
        ("OtherPoints", "settings"),
        ("SwapsIdentity", "identity"),
        ("AcceptsAnybody", "identity"),
        ("MeasuredBefore", "new_sweeps"),
        ("ConfirmsAnything", "reconnection"),
        ("NeedsNoLink", "reconnection"),
    ],
)
def test_each_bad_class_is_caught(name, check):
    assert check in failures(name)


@each_case(
    "spoil",
    [
        lambda former, data: former,
        # It is read before the sweep has reached the upper frequencies.
        lambda former, data: np.concatenate((data[:10], former[10:])),
        lambda former, data: data.real * (1 + 1j),
    ],
)
def test_data_that_are_not_those_of_one_new_sweep_are_caught(spoil):
    options = {"instrument": ToyInstrument(), "spoil": spoil}
    assert "new_sweeps" in failures("Spoils", analyzer_options=options)


def test_a_person_who_changes_what_is_measured_shows_whether_the_next_sweep_is_old():
    for name, expected in (("Good", Status.PASSED), ("LearnsAndIsLate", Status.FAILED)):
        bench = bench_of(name)
        instrument = bench.parameters.analyzer_options["instrument"]

        def take_the_cable_off(_text: Message, instrument=instrument) -> None:
            instrument.level = 1e-3

        found = {one.check: one for one in results(bench, take_the_cable_off)}
        assert found["by_hand"].status is expected, found["by_hand"]


def test_the_simulated_ms2026c_passes():
    with CheckedSimulation(
        read_scene(str(SCENE)), AnalyzerOptions(seconds_per_point=5e-4)
    ) as simulation:
        bench = simulation.bench(replace(QUICK, bandwidths_hz=(1e5,), sweeps=3))
        bench.parameters = replace(bench.parameters, display_settle_s=0.02)
        found = {one.check: one for one in results(bench, simulation.move)}
    failed = {one.check for one in found.values() if one.status is Status.FAILED}
    assert not failed, [found[one] for one in failed]
    assert found["sweep_end"].text.values["end_ms"] >= 21 * 0.5
    assert "lag_ms" in found["sweep_end"].text.values


@pytest.fixture
def module(tmp_path, monkeypatch):
    """A class in a module of its own, whose source changes."""
    folder = tmp_path / "code"
    folder.mkdir()
    shutil.copy(toy_vna.__file__, folder / "checked_vna.py")
    monkeypatch.syspath_prepend(str(folder))
    yield folder / "checked_vna.py"
    sys.modules.pop("checked_vna", None)


def test_a_record_holds_for_the_source_and_the_options_that_were_checked(tmp_path, module):
    options = {"instrument": 1}
    values = {"analyzer": "checked_vna:ToyVna", "analyzer_options": options}
    parameters = VnaParameters(**values)
    good = [Result("identity", Status.PASSED, verbatim("Toy"))]
    bad = [*good, Result("settings", Status.FAILED, verbatim("no"))]
    assert not has_passed(tmp_path, parameters)
    store(tmp_path, parameters, bad)
    assert not has_passed(tmp_path, parameters)
    store(tmp_path, parameters, good)
    store(tmp_path, VnaParameters(), good)
    assert has_passed(tmp_path, parameters)
    assert not has_passed(
        tmp_path, VnaParameters(**{**values, "analyzer_options": {"instrument": 2}})
    )
    assert len(json.loads((tmp_path / FILE).read_text())["analyzers"]) == 2
    module.write_text(module.read_text() + "\n# another version\n")
    assert not has_passed(tmp_path, parameters)
    (tmp_path / FILE).write_text("{")
    assert not has_passed(tmp_path, parameters)


def run(monkeypatch, *arguments) -> int:
    monkeypatch.setattr(sys, "argv", ["check_analyzer", *map(str, arguments)])
    return check_analyzer.main()


def test_the_program_prints_a_table_and_stores_what_it_found(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(check_analyzer, "Extent", lambda: QUICK)
    monkeypatch.setenv("LANG", "C")
    instrument = f"{__name__}:OnePiece"
    (tmp_path / "analyzer.yaml").write_text(
        f"analyzer: {instrument}\nmaker: {MAKER}\nmodel: {MODEL}\n"
    )
    assert run(monkeypatch, "--config", tmp_path) == 0
    printed = capsys.readouterr().out
    assert "NOT TESTED  sweep_end" in printed and "PASSED      new_sweeps" in printed
    record = json.loads((tmp_path / FILE).read_text())["analyzers"][0]
    assert record["passed"] and record["analyzer"] == instrument
    (tmp_path / "analyzer.yaml").write_text(f"analyzer: {instrument}\nmaker: {MAKER}\n")
    assert run(monkeypatch, "--config", tmp_path) == 1, "the model is another one"
    assert json.loads((tmp_path / FILE).read_text())["analyzers"] == [record]


class OnePiece(ToyVna):
    """A class that needs no options."""

    common = ToyInstrument()

    def __init__(self, parameters, deadline):
        super().__init__(parameters, deadline, self.common)


@each_case("text", ["analyzer: ms2027c", "colour: red", "address: 1.2.3"])
def test_the_program_refuses_what_it_cannot_check(tmp_path, monkeypatch, capsys, text):
    (tmp_path / "analyzer.yaml").write_text(text)
    assert run(monkeypatch, "--config", tmp_path) == 1
    assert "check_analyzer:" in capsys.readouterr().err
    assert not (tmp_path / FILE).exists()


def test_a_class_that_cannot_be_loaded_is_not_recorded(tmp_path, monkeypatch, capsys):
    (tmp_path / "analyzer.yaml").write_text("analyzer: no_such_module:X")
    assert run(monkeypatch, "--config", tmp_path) == 1
    assert "no_such_module" in capsys.readouterr().out
    assert not (tmp_path / FILE).exists()
