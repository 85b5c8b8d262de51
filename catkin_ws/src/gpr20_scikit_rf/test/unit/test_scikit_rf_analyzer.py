"""The analyzers of scikit-rf over PyVISA, at instruments that are simulated below it."""

from __future__ import annotations

import contextlib
import importlib.util
import sys
from types import SimpleNamespace
from typing import Callable, Iterator

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from scpi_analyzers import ANALYZERS, ScpiAnalyzer, ScpiServer
from wait_kit import wait_until

from gpr20_common import faults as common_faults
from gpr20_common.faults import CONFIGURATION
from gpr20_scikit_rf import ScikitRfAnalyzer
from gpr20_scikit_rf.low.visa_link import VisaLibrary
from gpr20_simulator.low.message_device import ClearSupport, NetworkFault, Outcome
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_survey.faults import (
    VNA_DOUBTFUL,
    VNA_FAILED,
    VNA_SETTINGS,
    VNA_SILENT,
    WRONG_VNA,
)
from gpr20_survey.trace.sweep import AnalyzerSettings, CalibrationStatus, SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaError,
    VnaSettingError,
    VnaSweepError,
)
from gpr20_vna_acquisition.mid.analyzers import ForeignAnalyzer, make_foreign_analyzer
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

FREQUENCIES = 600_000_000.0, 6_000_000_000.0, 51
SWEEP = SweepSettings(*FREQUENCIES)
# The first scikit-rf for Python 3.8 has no class of Rohde & Schwarz that works.
HAS_ROHDE_SCHWARZ = importlib.util.find_spec("skrf.vi.vna.rohde_schwarz.rs_vna") is not None
# The class ZNA differs from ZVA in its name alone.
CLASSES = ["keysight.PNA", "keysight.FieldFox", *["rohde_schwarz.ZVA"] * HAS_ROHDE_SCHWARZ]
# For what is waited for in vain [s].
IMPATIENT = {"answer_timeout_s": 0.3, "sweep_timeout_s": 0.3}


class Bench:
    """An instrument, and the analyzer and driver at it."""

    def __init__(self, name: str, options=None, clock=None, **parameters) -> None:
        self.vna: ScpiAnalyzer = ANALYZERS[name]()
        self.server = ScpiServer(self.vna)
        self.address = self.server.address
        self.parameters = VnaParameters(
            **{
                "analyzer": "gpr20_scikit_rf:ScikitRfAnalyzer",
                "analyzer_options": {"scikit_rf_class": name, **(options or {})},
                "address": self.address,
                "maker": self.vna.maker,
                "model": self.vna.model,
                "answer_timeout_s": 5.0,
                "connect_timeout_s": 10.0,
                "sweep_timeout_s": 5.0,
                "seconds_per_point": 0.0,
                "retry_pause_s": 0.01,
                "attempts": 3,
                "clear_on_connect": False,
                "accepted_calibrations": (CalibrationStatus.NOT_REPORTED,),
                **parameters,
            }
        )
        self.deadline = RequestDeadline(clock or self.vna.clock)
        self.deadline.begin(600.0)
        self.analyzer = ScikitRfAnalyzer(
            self.parameters, self.deadline, **self.parameters.analyzer_options
        )
        foreign = ForeignAnalyzer(self.analyzer, self.parameters, self.deadline)
        self.driver = VNADriver(foreign, self.parameters, self.deadline, lambda _text: None)

    def linked(self) -> Bench:
        self.analyzer.connect(self.address)
        self.analyzer.identify()
        return self

    def configured(self, **settings) -> SweepSettings:
        settings = SweepSettings(*FREQUENCIES, analyzer=AnalyzerSettings(**settings))
        return self.linked().analyzer.configure(settings)

    def driven(self) -> VNADriver:
        """Return the driver, set up."""
        assert self.driver.connect_to_vna(self.address) == self.vna.identity
        self.driver.set_frequency_sweep(SWEEP)
        return self.driver

    def stop(self) -> None:
        self.analyzer.disconnect()
        self.server.stop()


@pytest.fixture
def make() -> Iterator[Callable[..., Bench]]:
    """Make benches that are stopped in the end."""
    with contextlib.ExitStack() as ending:

        def make_bench(name="keysight.PNA", *options, **parameters):
            made = Bench(name, *options, **parameters)
            ending.callback(made.stop)
            return made

        yield make_bench


@pytest.fixture(params=CLASSES)
def bench(request, make) -> Bench:
    return make(request.param)


@pytest.fixture
def pna(make) -> Bench:
    return make()


def test_each_sweep_was_triggered_after_the_request(bench):
    accepted = bench.configured()
    assert accepted.fulfils(SWEEP) and accepted.analyzer.averages == 1
    # It averaged, and sweeps of before a move would have been in a trace.
    averaging = {"SENS1:AVER:STATE": "0", "SENS:AVER:COUN": "1"}
    assert bench.vna.values.items() & averaging.items()
    for _ in range(3):
        before = bench.vna.sweeps
        sweep = bench.analyzer.sweep()
        bench.analyzer.confirm()
        assert set(sweep.s21_real) == {before + 1} and bench.vna.sweeps == before + 1
        np.testing.assert_array_equal(sweep.frequency_hz, SWEEP.frequencies_hz())
        assert sweep.duration_s == pytest.approx(bench.vna.sweep_s, abs=1e-5)
    assert bench.analyzer.trace_duration_s == pytest.approx(bench.vna.sweep_s)
    # Only settings that differ are written.
    bench.vna.written.clear()
    bench.analyzer.configure(SWEEP)
    headers = {one.split(" ")[0] for one in bench.vna.written} & set(bench.vna.settings)
    assert not [one for one in headers if not one.startswith("CALC")], headers
    assert bench.analyzer.remarks == []


def test_settings_are_read_back(bench):
    bench.vna.ignored.add(bench.vna.points_header)
    with raises_fault(VNA_SETTINGS, 201, 51):
        bench.configured()


def test_the_if_bandwidth_of_the_survey_is_set(bench):
    assert bench.configured(if_bandwidth_hz=3000.0).analyzer == AnalyzerSettings(3000.0, 1)
    assert bench.analyzer.sweep().analyzer.if_bandwidth_hz == 3000.0


def test_what_is_changed_by_hand_is_noticed(bench):
    bench.configured()
    header = bench.vna.points_header.replace("SWE:POIN", "FREQ:STOP")
    bench.vna.values[header] = "5E9"
    with raises_fault(VNA_SETTINGS, 5000000000, 6000000000):
        bench.analyzer.confirm()
    # An instrument that sweeps by itself gives no trace.
    bench.analyzer.configure(SWEEP)
    header, value = bench.vna.continuous
    bench.vna.values[header] = value
    with raises_fault(VNA_SETTINGS):
        bench.analyzer.sweep()


def test_old_data_are_refused(bench):
    bench.vna.old_data = True
    bench.configured()
    with raises_fault(VNA_FAILED):
        bench.analyzer.sweep()


def test_an_end_that_is_reported_too_early_is_refused(bench):
    bench.vna.sweep_s = 0.2
    bench.configured()
    bench.vna.early_end = True
    with raises_fault(VNA_FAILED, error=VnaSweepError):
        bench.analyzer.sweep()


def test_an_instrument_that_never_waits_for_its_sweep_is_refused_at_once(pna):
    pna.vna.early_end = True
    pna.vna.sweep_s = 0.2
    with raises_fault(VNA_FAILED, error=VnaSettingError):
        pna.configured()


def test_release_leaves_it_sweeping_by_itself_also_after_a_shutdown(bench):
    bench.configured()
    assert not bench.vna.is_continuous
    bench.deadline.close()
    bench.analyzer.release()
    # A last command has no answer.
    wait_until(lambda: bench.vna.is_continuous)


def test_its_calibration_is_not_reported(bench):
    bench.configured()
    assert bench.analyzer.calibration() is CalibrationStatus.NOT_REPORTED
    (remark,) = bench.analyzer.remarks
    assert remark.fault == VNA_DOUBTFUL and "the start frequency" in str(remark)


@each_case(
    "settings",
    [
        AnalyzerSettings(output_power="HIGH"),
        AnalyzerSettings(if_bandwidth_hz=1.5),
        AnalyzerSettings(averages=2),
    ],
)
def test_settings_that_it_does_not_have_are_refused(bench, settings):
    with raises_fault(common_faults.NOT_ALLOWED):
        bench.analyzer.check_sweep(SweepSettings(*FREQUENCIES, analyzer=settings))
    bench.analyzer.check_sweep(SWEEP)


def test_another_instrument_and_another_kind_of_address_are_refused(pna):
    with raises_fault(common_faults.NOT_ALLOWED, "192.168.1.10"):
        pna.analyzer.connect("192.168.1.10")
    pna.vna.model = "SA9000"
    with raises_fault(WRONG_VNA, "SA9000"):
        pna.linked()
    pna.server.stop()
    with pytest.raises(VnaConnectionError):
        pna.linked()


@pytest.mark.parametrize("name", CLASSES)
def test_no_answer_is_an_error_and_a_new_link_works(make, name):
    bench = make(name, **IMPATIENT)
    for query in ("*IDN?", "*OPC?", ""):
        bench.vna.silent = {query}
        with raises_fault(VNA_SILENT):
            bench.configured()
    bench.vna.silent = set()
    bench.configured()
    bench.server.drop_all()
    with pytest.raises(VnaConnectionError):
        bench.analyzer.sweep()
    with pytest.raises(VnaError):
        bench.analyzer.confirm()
    bench.linked().analyzer.confirm()
    assert bench.analyzer.sweep().s21_real[0] == bench.vna.sweeps


@each_case(
    "answer",
    [
        *(b"\n", b"garbage\n", b"1,2,3\n", b"#0\n", b"#216" + bytes(16) + b"\n"),
        b",".join([*[b"1"] * 101, b"nan\n"]),
    ],
)
def test_data_that_are_wrong_are_an_error(bench, answer):
    bench.vna.answers.clear()
    bench.configured()
    query = "CALC:DATA:SDATA?" if "FieldFox" in str(bench.parameters) else "CALC1:DATA? SDATA"
    bench.vna.answers[query] = answer
    with pytest.raises(VnaError):
        bench.analyzer.sweep()


def test_a_link_ends_with_an_answer_that_was_not_understood(pna):
    pna.configured()
    pna.vna.answers["SENS1:SWE:POIN?"] = b"garbage\n"
    with raises_fault(CONFIGURATION):
        pna.analyzer.confirm()
    pna.vna.answers.clear()
    with pytest.raises(VnaConnectionError):
        pna.analyzer.confirm()


@each_case(
    "name, query, answer",
    [
        ("keysight.PNA", "SENS1:SWE:TIME?", b"9.91E37\n"),
        ("keysight.FieldFox", "SENS:SWE:TIME?", b"inf\n"),
        ("keysight.FieldFox", "SENS:BWID?", b"nan\n"),
    ],
)
def test_impossible_values_are_refused(make, name, query, answer):
    bench = make(name)
    bench.vna.answers[query] = answer
    with raises_fault(VNA_FAILED):
        bench.configured()


# The whole driver.


def test_the_driver_takes_confirmed_traces(bench):
    driver = bench.driven()
    driver.get_trace()
    (unsure,) = bench.analyzer.remarks
    assert unsure in driver.state.last_quality
    number, _sweep = driver.take_sweep()
    assert driver.confirm(number).remarks == ()
    assert unsure not in driver.state.last_quality
    # It repeats a sweep over a new link.
    bench.vna.drop_at = "*OPC?"
    sweep = driver.get_trace()
    # Some sessions notice only by the time limit that the link is gone.
    lost = {VNA_SILENT.code, VNA_SETTINGS.code}
    assert lost & {one.fault_code for one in driver.state.last_quality}
    assert sweep.s21_real[0] == bench.vna.sweeps
    driver.disconnect_from_vna()
    # A last command has no answer.
    wait_until(lambda: bench.vna.is_continuous)


# Another kind of session.


def test_a_session_over_vxi11_begins_with_empty_buffers(make):
    bench = make("keysight.PNA", clear_on_connect=True)
    clears = []
    device = SimpleNamespace(
        is_reachable=lambda: True,
        opened=lambda: NetworkFault.NONE,
        execute=lambda message: Outcome(bench.vna.execute(message) or b""),
        clear=lambda: clears.append(1) or ClearSupport.FULL,
        set_remote=lambda _remote: None,
    )
    server = Vxi11Server(device)
    server.start()
    bench.address = f"TCPIP0::127.0.0.1,{server.port}::inst0::INSTR"
    try:
        bench.configured()
        assert clears == [1]
        assert bench.analyzer.sweep().s21_real[0] == bench.vna.sweeps
        bench.analyzer.confirm()
        bench.analyzer.release()
        wait_until(lambda: bench.vna.is_continuous)
        bench.analyzer.disconnect()
    finally:
        server.stop()


# The libraries.


def test_a_library_or_class_that_is_missing_is_named(pna, monkeypatch):
    for name, library in (("keysight.None", "@py"), ("keysight.PNA", "/none.so")):
        with raises_fault(CONFIGURATION, name, repr(library), "setup.sh --scikit-rf"):
            VisaLibrary(name, library, 1.0, clear=False)
    monkeypatch.setitem(sys.modules, "pyvisa", None)
    with raises_fault(CONFIGURATION, "setup.sh --scikit-rf"):
        make_foreign_analyzer(pna.parameters, pna.deadline)
