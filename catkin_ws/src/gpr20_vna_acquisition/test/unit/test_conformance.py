"""The checks of analyzers pass a good class and catch each bad one."""

from __future__ import annotations

import json
import sys
from dataclasses import replace

import pytest
from case_kit import each_case
from fault_kit import raises_fault
from line_vna import LineVna
from socket_vna import SocketVna  # the class of the tutorial is a good one

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Scene
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import LOCKED
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect
from gpr20_vna_acquisition.mid.analyzers import FILE, Result, Status, has_passed, passed, store
from gpr20_vna_acquisition.mid.conformance import Bench, Extent, results
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

pytest.importorskip("rosgraph")

from gpr20_vna_acquisition.high import check_analyzer

QUICK = Extent(21, (1e4,), sweeps=3, watched_s=0.05, limit_s=60.0)


@pytest.fixture
def vna():
    with LineVna() as vna:
        yield vna


def bench_of(name: str, vna: LineVna, extent: Extent = QUICK, **changed) -> Bench:
    values = {
        "analyzer": f"{__name__}:{name}",
        "analyzer_options": {"port": vna.port},
        "maker": "CMT",
        "model": "S5085",
        **changed,
    }
    return Bench(VnaParameters(**values), lambda _address: None, extent)


class IsLate(SocketVna):
    """Gives what it has shown before, which its sweeps at set-up hide from most checks."""

    shown = None

    def sweep(self):
        shown, self.shown = self.shown, super().sweep()
        shown = shown or self.shown
        return replace(self.shown, s21_real=shown.s21_real, s21_imag=shown.s21_imag)


class ConfirmsAnything(SocketVna):
    """Does not read the settings again."""

    def confirm(self):
        if self._accepted is None:
            raise errors.not_configured()


class DoesNotWait(SocketVna):
    """Gives data before its filter can have settled."""

    def sweep(self):
        sweep = super().sweep()
        return replace(sweep, sweep_ended_us=sweep.sweep_started_us + 1)


class NeedsNoLink(SocketVna):
    """Gives its last data where there is no link."""

    def sweep(self):
        if self._link is not None:
            self.last = super().sweep()
        return self.last


def found_of(bench: Bench):
    return {one.check: one for one in results(bench)}


def test_a_good_class_passes_and_what_needs_its_messages_is_not_tested(vna):
    found = found_of(bench_of("SocketVna", vna))
    assert passed(list(found.values())), found
    assert found["sweep_end"].status is found["by_hand"].status is Status.NOT_TESTED
    assert found["first_sweep"].status is found["sweep_times"].status is Status.PASSED


@each_case(
    "name, check",
    [
        ("DoesNotWait", "sweep_times"),
        ("ConfirmsAnything", "reconnection"),
        ("NeedsNoLink", "reconnection"),
    ],
)
def test_each_bad_class_is_caught(name, check):
    with LineVna() as vna:
        bench = bench_of(name, vna)
        assert any(one.check == check and one.status is Status.FAILED for one in results(bench))


def test_a_person_who_changes_what_is_measured_shows_whether_the_next_sweep_is_old(vna):
    for name, expected in (("SocketVna", Status.PASSED), ("IsLate", Status.FAILED)):
        vna.level = 0.1

        def take_the_cable_off(_text: Message) -> None:
            vna.level = 1e-3

        bench = bench_of(name, vna)
        bench.ask = take_the_cable_off
        found = found_of(bench)
        assert found["by_hand"].status is expected, found["by_hand"]


@pytest.fixture
def wired():
    """A simulated MS2026C on a socket, and the places of its antennas, the last of which counts."""
    places = [AntennaPosition(300.0, 400.0, 90.0), AntennaPosition(100.0, 100.0, 0.0)]
    ground = Ground(Scene()), lambda: places[-1]
    vna = SimulatedAnalyzer(*ground, Clock(), Scene().instrument, AnalyzerOptions())
    vna.start()
    yield vna, places
    vna.stop()


def test_the_simulated_ms2026c_passes_and_is_locked_meanwhile(wired):
    vna, places = wired

    def to_instrument(address):
        return connect(address, LinkLimits(), vna.server.port)

    def change_what_is_measured(_text: Message) -> None:
        places.pop()
        with raises_fault(LOCKED, error=errors.VnaConnectionError):
            to_instrument("127.0.0.1").write(":INIT:CONT ON")

    bench = Bench(
        VnaParameters(display_settle_s=0.02),
        to_instrument,
        replace(QUICK, bandwidths_hz=(1e5,), sweeps=3),
        change_what_is_measured,
    )
    found = found_of(bench)
    assert passed(list(found.values())), found
    assert 0.0 <= found["sweep_end"].text.values["lag_ms"] < 50.0
    # No lock is left behind.
    to_instrument("127.0.0.1").write(":INIT:CONT ON")


# The program, and what it stores.


def test_a_record_holds_for_the_source_and_the_options_that_were_checked(tmp_path, monkeypatch):
    module = tmp_path / "checked_vna.py"
    module.write_text("from socket_vna import SocketVna\n\n\nclass Checked(SocketVna):\n    pass\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    values = {"analyzer": "checked_vna:Checked", "analyzer_options": {"port": 1}}
    parameters = VnaParameters(**values)
    good = [Result("identity", Status.PASSED, verbatim("CMT"))]
    assert not has_passed(tmp_path, parameters)
    for checked, found, holds in (
        (parameters, [*good, Result("settings", Status.FAILED, verbatim("no"))], False),
        (VnaParameters(), good, False),
        (parameters, good, True),
    ):
        store(tmp_path, checked, found)
        assert has_passed(tmp_path, parameters) is holds
    other = VnaParameters(**{**values, "analyzer_options": {"port": 2}})
    assert not has_passed(tmp_path, other)
    module.write_text(module.read_text() + "\n# another version\n")
    assert not has_passed(tmp_path, parameters)
    (tmp_path / FILE).write_text("{")
    assert not has_passed(tmp_path, parameters)


def run(monkeypatch, *arguments) -> int:
    monkeypatch.setattr(sys, "argv", ["check_analyzer", *map(str, arguments)])
    return check_analyzer.main()


def test_the_program_prints_a_table_and_stores_what_it_found(tmp_path, monkeypatch, capsys, vna):
    monkeypatch.setattr(check_analyzer, "Extent", lambda: QUICK)
    monkeypatch.setenv("LANG", "C")
    content = (
        f"analyzer: socket_vna:SocketVna\nanalyzer_options: {{port: {vna.port}}}\nmaker: CMT\n"
    )
    (tmp_path / "analyzer.yaml").write_text(content + "model: S5085\n")
    assert run(monkeypatch, "--config", tmp_path) == 0
    printed = capsys.readouterr().out
    assert "NOT TESTED  sweep_end" in printed and "PASSED      new_sweeps" in printed
    record = json.loads((tmp_path / FILE).read_text())
    assert record["passed"] and record["analyzer"] == "socket_vna:SocketVna"
    (tmp_path / "analyzer.yaml").write_text(content)
    assert run(monkeypatch, "--config", tmp_path) == 1, "the model is another one"
    assert json.loads((tmp_path / FILE).read_text()) == record
