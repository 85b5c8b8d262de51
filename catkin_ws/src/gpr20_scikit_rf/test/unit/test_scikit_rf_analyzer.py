"""The analyzers of scikit-rf over PyVISA, at instruments that are simulated below it."""

from __future__ import annotations

import contextlib
import importlib.util
import sys
import threading
import time
from typing import Callable, Iterator

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from scpi_analyzers import ANALYZERS, ScpiAnalyzer, ScpiServer

from gpr20_common import faults as common_faults
from gpr20_common.low.clock import Clock
from gpr20_scikit_rf import ScikitRfAnalyzer
from gpr20_scikit_rf import faults as own_faults
from gpr20_scikit_rf.low.visa_link import VisaLibrary, VisaLimits
from gpr20_simulator.low.message_device import ClearSupport, NetworkFault, Outcome
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import AnalyzerSettings, SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import (
    VnaClosedError,
    VnaConnectionError,
    VnaError,
    VnaSettingError,
    VnaSweepError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.foreign_analyzer import ForeignAnalyzer, make_foreign_analyzer
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SWEEP = SweepSettings(600_000_000.0, 6_000_000_000.0, 51)
# The first scikit-rf for Python 3.8 has no class of Rohde & Schwarz that works.
HAS_ROHDE_SCHWARZ = importlib.util.find_spec("skrf.vi.vna.rohde_schwarz.rs_vna") is not None
# The class ZNA differs from ZVA in its name alone.
CLASSES = ["keysight.PNA", "keysight.FieldFox", *["rohde_schwarz.ZVA"] * HAS_ROHDE_SCHWARZ]


class Bench:
    """An instrument, and the analyzer and driver at it."""

    def __init__(self, name: str, options=None, **parameters) -> None:
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
                "answer_timeout_s": 0.3,
                "connect_timeout_s": 0.5,
                "sweep_timeout_s": 0.3,
                "seconds_per_point": 0.0,
                "request_timeout_s": 8.0,
                "retry_pause_s": 0.01,
                "attempts": 3,
                "clear_on_connect": False,
                "accepted_calibrations": (CalibrationStatus.NOT_REPORTED,),
                **parameters,
            }
        )
        self.deadline = RequestDeadline(Clock())
        self.deadline.begin(60.0)
        self.analyzer = ScikitRfAnalyzer(
            self.parameters, self.deadline, **self.parameters.analyzer_options
        )
        foreign = ForeignAnalyzer(lambda _lent: self.analyzer, self.parameters, self.deadline)
        self.driver = VNADriver(foreign, self.parameters, self.deadline, lambda _text: None)

    def configured(self, **settings) -> SweepSettings:
        self.analyzer.connect(self.address)
        self.analyzer.identify()
        return self.analyzer.configure(
            SweepSettings(*_frequencies(), analyzer=AnalyzerSettings(**settings))
        )

    def stop(self) -> None:
        self.analyzer.disconnect()
        self.server.stop()


def _frequencies():
    return SWEEP.start_frequency_hz, SWEEP.stop_frequency_hz, SWEEP.points


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
    for _ in range(5):
        before = bench.vna.sweeps
        sweep = bench.analyzer.sweep()
        bench.analyzer.confirm()
        assert set(sweep.s21_real) == {before + 1} and bench.vna.sweeps == before + 1
        np.testing.assert_array_equal(sweep.frequency_hz, SWEEP.frequencies_hz())
        assert sweep.duration_s >= bench.vna.sweep_s
    assert bench.analyzer.trace_duration_s >= bench.vna.sweep_s


def test_only_settings_that_differ_are_written(bench):
    bench.configured()
    bench.vna.written.clear()
    bench.analyzer.configure(SWEEP)
    written = bench.vna.settings_written()
    assert not [one for one in written if not one.startswith("CALC")], written


def test_settings_are_read_back(bench):
    bench.vna.faults.ignored.add(bench.vna.points_header)
    with raises_fault(faults.SETTING_REFUSED, 201, 51):
        bench.configured()


def test_if_bandwidth_and_averages_are_set_and_each_trace_is_a_new_average(bench):
    accepted = bench.configured(if_bandwidth_hz=3000.0, averages=3)
    assert accepted.analyzer == AnalyzerSettings(3000.0, 3)
    before = bench.vna.sweeps
    sweep = bench.analyzer.sweep()
    assert bench.vna.average_cleared_at == before and bench.vna.sweeps == before + 3
    assert sweep.analyzer == accepted.analyzer
    assert bench.analyzer.trace_duration_s >= 3 * bench.vna.sweep_s


def test_a_setting_that_is_changed_by_hand_is_noticed(bench):
    bench.configured()
    header = bench.vna.points_header.replace("SWE:POIN", "FREQ:STOP")
    bench.vna.values[header] = "5E9"
    with raises_fault(faults.SETTINGS_CHANGED, 5000000000, 6000000000):
        bench.analyzer.confirm()


def test_an_instrument_that_sweeps_by_itself_gives_no_trace(bench):
    bench.configured()
    header, value = bench.vna.continuous
    bench.vna.values[header] = value
    with raises_fault(faults.SETTINGS_CHANGED):
        bench.analyzer.sweep()


def test_old_data_are_refused(bench):
    bench.vna.faults.old_data = True
    bench.configured()
    with raises_fault(faults.OLD_DATA):
        bench.analyzer.sweep()


def test_an_end_that_is_reported_too_early_is_refused(bench):
    bench.vna.sweep_s = 0.2
    bench.configured()
    bench.vna.faults.early_end = True
    with raises_fault(own_faults.SWEEP_TOO_EARLY, error=VnaSweepError):
        bench.analyzer.sweep()


def test_an_instrument_that_never_waits_for_its_sweep_is_refused_at_once(pna):
    pna.vna.faults.early_end = True
    pna.vna.sweep_s = 0.2
    with raises_fault(own_faults.SWEEP_TOO_EARLY, error=VnaSettingError):
        pna.configured()


def test_release_leaves_it_sweeping_by_itself_also_after_a_shutdown(bench):
    bench.configured()
    assert not bench.vna.is_continuous
    bench.deadline.close()
    bench.analyzer.release()
    assert_released(bench)


def test_its_calibration_is_not_reported(bench):
    bench.configured()
    assert bench.analyzer.calibration() is CalibrationStatus.NOT_REPORTED
    (remark,) = bench.analyzer.remarks
    assert remark.fault == own_faults.CALIBRATION_UNSURE and "the start frequency" in str(remark)
    bench.analyzer.configure(SWEEP)
    assert bench.analyzer.remarks == []


@each_case(
    "answer, status", [(b"0\n", CalibrationStatus.NONE), (b"1\n", CalibrationStatus.NOT_REPORTED)]
)
def test_a_configured_query_tells_whether_it_is_calibrated(make, answer, status):
    bench = make("keysight.PNA", {"correction_query": "SENS1:CORR:STAT?"})
    bench.configured()
    bench.vna.faults.answers["SENS1:CORR:STAT?"] = answer
    assert bench.analyzer.calibration() is status
    bench.vna.faults.answers["SENS1:CORR:STAT?"] = b"perhaps\n"
    with raises_fault(own_faults.NOT_UNDERSTOOD, "'PERHAPS'", "SENS1:CORR:STAT?"):
        bench.analyzer.calibration()


def test_a_calibration_that_is_lost_when_a_setting_is_written_is_said(make):
    bench = make("keysight.PNA", {"correction_query": "SENS1:CORR:STAT?"})
    command = bench.vna.command

    def losing(header, *value):
        if header == "SENS1:FREQ:STOP":
            bench.vna.faults.answers["SENS1:CORR:STAT?"] = b"0\n"
        command(header, *value)

    bench.vna.command = losing
    with raises_fault(faults.CALIBRATION_LOST):
        bench.configured()


@each_case(
    "settings",
    [
        AnalyzerSettings(output_power="HIGH"),
        AnalyzerSettings(if_bandwidth_hz=1.5),
    ],
)
def test_settings_that_it_does_not_have_are_refused(bench, settings):
    with raises_fault(common_faults.NOT_ALLOWED):
        bench.analyzer.check_sweep(SweepSettings(*_frequencies(), analyzer=settings))
    bench.analyzer.check_sweep(SWEEP)


@each_case("address", ["192.168.1.10", "TCPIP0", "a::b c", "", "x::" + "y" * 200])
def test_an_address_that_is_no_visa_resource_is_refused(pna, address):
    with raises_fault(common_faults.NOT_ALLOWED, address[:64]):
        pna.analyzer.connect(address)


def test_another_instrument_is_refused(bench):
    bench.vna.model = "SA9000"
    bench.analyzer.connect(bench.address)
    with raises_fault(faults.WRONG_INSTRUMENT, "SA9000"):
        bench.analyzer.identify()


@each_case("query", ["*IDN?", "*OPC?", ""])
def test_no_answer_is_an_error_in_bounded_time(bench, query):
    bench.vna.faults.silent = {query}
    begun_s = time.monotonic()
    with raises_fault(faults.NO_LINK):
        bench.configured()
    # Much sooner than an exchange that only the limit of the whole call ends.
    assert time.monotonic() - begun_s < 1.3


def test_a_link_that_drops_is_an_error_and_a_new_one_works(bench):
    bench.configured()
    bench.server.drop_all()
    with pytest.raises(VnaConnectionError):
        bench.analyzer.sweep()
    with pytest.raises(VnaError):
        bench.analyzer.confirm()
    bench.analyzer.connect(bench.address)
    bench.analyzer.identify()
    bench.analyzer.confirm()
    assert bench.analyzer.sweep().s21_real[0] == bench.vna.sweeps


def test_nothing_at_the_address_is_an_error(pna):
    pna.server.stop()
    with pytest.raises(VnaConnectionError):
        pna.configured()


def assert_released(bench: Bench) -> None:
    # A last command has no answer.
    deadline_s = time.monotonic() + 2.0
    while not bench.vna.is_continuous and time.monotonic() < deadline_s:
        time.sleep(0.001)
    assert bench.vna.is_continuous


def data_query(bench: Bench) -> str:
    return "CALC:DATA:SDATA?" if "FieldFox" in str(bench.parameters) else "CALC1:DATA? SDATA"


@each_case(
    "answer", [b"\n", b"garbage\n", b"1,2,3\n", b"#0\n", b"1,nan\n", b"#216" + bytes(16) + b"\n"]
)
def test_data_that_are_wrong_are_an_error(bench, answer):
    bench.vna.faults.answers.clear()
    bench.configured()
    bench.vna.faults.answers[data_query(bench)] = answer
    with pytest.raises(VnaError):
        bench.analyzer.sweep()


def test_numbers_that_are_not_finite_are_refused(bench):
    bench.configured()
    data = bench.vna.data

    def with_nan():
        numbers = data()
        numbers[7] = np.nan
        return numbers

    bench.vna.data = with_nan
    with raises_fault(faults.BAD_DATA):
        bench.analyzer.sweep()


@each_case(
    "name, query, answer",
    [
        ("keysight.PNA", "SENS1:SWE:TIME?", b"9.91E37\n"),
        ("keysight.PNA", "SENS1:BWID?", b"9.91E37\n"),
        ("keysight.FieldFox", "SENS:SWE:TIME?", b"inf\n"),
        ("keysight.FieldFox", "SENS:BWID?", b"nan\n"),
        ("keysight.FieldFox", "SENS:AVER:COUN?", b"1E9\n"),
    ],
)
def test_impossible_values_are_refused(make, name, query, answer):
    bench = make(name)
    bench.vna.faults.answers[query] = answer
    with raises_fault(faults.BAD_DATA):
        bench.configured()


def test_one_slow_sweep_while_the_duration_is_learned_does_no_harm(pna):
    trigger, slow = pna.vna.trigger, iter((0.02, 0.3, 0.02))

    def sometimes_slow():
        pna.vna.sweep_s = next(slow, 0.02)
        trigger()

    pna.vna.trigger = sometimes_slow
    pna.configured()
    for _ in range(3):
        pna.analyzer.sweep()


def test_an_answer_without_end_is_given_up(pna):
    pna.configured()
    pna.vna.faults.endless = "CALC1:PAR:SEL?"
    before = threading.active_count()
    begun_s = time.monotonic()
    with raises_fault(faults.NO_LINK):
        pna.analyzer.sweep()
    assert time.monotonic() - begun_s < 3.0
    deadline_s = time.monotonic() + 5.0
    while threading.active_count() >= before and time.monotonic() < deadline_s:
        time.sleep(0.01)
    assert threading.active_count() < before


def test_a_shutdown_ends_a_sweep_that_is_waited_for(pna):
    pna.configured()
    pna.vna.sweep_s = 30.0
    pna.analyzer._sweeps._sweep_s = 30.0
    threading.Timer(0.2, pna.deadline.close).start()
    begun_s = time.monotonic()
    with pytest.raises(VnaClosedError):
        pna.analyzer.sweep()
    assert time.monotonic() - begun_s < 2.0


def test_the_time_limit_of_the_request_ends_a_sweep(pna):
    pna.configured()
    pna.vna.sweep_s = 30.0
    pna.analyzer._sweeps._sweep_s = 30.0
    pna.deadline.begin(0.3)
    with pytest.raises(VnaTimeoutError):
        pna.analyzer.sweep()


# The whole driver.


def test_the_driver_takes_confirmed_traces(bench):
    assert bench.driver.connect_to_vna(bench.address) == bench.vna.identity
    bench.driver.set_frequency_sweep(SWEEP)
    bench.driver.get_trace()
    assert own_faults.CALIBRATION_UNSURE in {one.fault for one in bench.driver.state.last_quality}
    number, _sweep = bench.driver.take_sweep()
    assert bench.driver.confirm(number).remarks == ()
    assert own_faults.CALIBRATION_UNSURE not in {
        one.fault for one in bench.driver.state.last_quality
    }
    bench.driver.disconnect_from_vna()
    assert_released(bench)


def test_the_driver_repeats_a_sweep_over_a_new_link(bench):
    bench.driver.connect_to_vna(bench.address)
    bench.driver.set_frequency_sweep(SWEEP)
    bench.driver.get_trace()
    # In the middle of the sweep.
    bench.vna.faults.drop_at = "*OPC?"
    sweep = bench.driver.get_trace()
    # Some sessions notice only by the time limit that the link is gone.
    lost = {faults.NO_LINK.code, faults.SWEEP_NOT_ENDED.code}
    assert lost & {one.fault_code for one in bench.driver.state.last_quality}
    assert sweep.s21_real[0] == bench.vna.sweeps


def test_the_driver_refuses_another_serial_number_at_a_reconnect(bench):
    bench.driver.connect_to_vna(bench.address)
    bench.driver.set_frequency_sweep(SWEEP)
    bench.vna.serial = "SIMULATED-2"
    bench.server.drop_all()
    with raises_fault(faults.REPLACED, "SIMULATED-2"):
        bench.driver.get_trace()


def test_without_leave_of_the_configuration_no_trace_is_taken(make):
    bench = make("keysight.PNA", accepted_calibrations=(CalibrationStatus.HIGH,))
    bench.driver.connect_to_vna(bench.address)
    bench.driver.set_frequency_sweep(SWEEP)
    with raises_fault(faults.CALIBRATION_UNREPORTED, 5):
        bench.driver.get_trace()


# Another kind of session.


class Vxi11Device:
    """The analyzer behind the simulator's VXI-11 server."""

    def __init__(self, vna: ScpiAnalyzer, clear_support: ClearSupport) -> None:
        self._vna = vna
        self._clear_support = clear_support
        self.cleared = 0

    def is_reachable(self) -> bool:
        return True

    def opened(self) -> NetworkFault:
        return NetworkFault.NONE

    def execute(self, message: bytes) -> Outcome:
        return Outcome(self._vna.execute(message) or b"")

    def clear(self) -> ClearSupport:
        self.cleared += 1
        return self._clear_support

    def set_remote(self, remote: bool) -> None:
        pass


@each_case("support", [ClearSupport.FULL, ClearSupport.ERROR_8])
def test_a_session_over_vxi11_begins_with_empty_buffers(make, support):
    bench = make("keysight.PNA", clear_on_connect=True)
    device = Vxi11Device(bench.vna, support)
    server = Vxi11Server(device)
    server.start()
    bench.address = f"TCPIP0::127.0.0.1,{server.port}::inst0::INSTR"
    try:
        bench.configured()
        assert device.cleared == 1
        assert bench.analyzer.sweep().s21_real[0] == bench.vna.sweeps
        bench.analyzer.confirm()
        bench.analyzer.release()
        assert_released(bench)
    finally:
        server.stop()


# The libraries.


def test_a_missing_library_says_what_to_install(pna, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvisa", None)
    with raises_fault(own_faults.LIBRARY_UNUSABLE, "setup.sh --scikit-rf"):
        make_foreign_analyzer(pna.parameters, pna.deadline)


def test_a_class_that_the_installed_scikit_rf_does_not_have_is_an_error():
    limits = VisaLimits(1.0, 1.0, clear=False)
    for name, needs in (("keysight.PNA", "skrf.vi.vna.of_tomorrow"), ("keysight.None", "")):
        with raises_fault(own_faults.LIBRARY_UNUSABLE, name):
            VisaLibrary(name, "@py", limits, needs)


def test_a_missing_visa_library_is_an_error():
    with raises_fault(own_faults.LIBRARY_UNUSABLE, "'/none.so'"):
        Bench("keysight.PNA", {"visa_library": "/none.so"})
