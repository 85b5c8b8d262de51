"""A few messages confirm a sweep, and show what they can of what happened meanwhile."""

from __future__ import annotations

import time
from typing import Iterator, Tuple

import pytest
from case_kit import each_case
from driver_bench import ADDRESS, Bench
from fault_kit import raises_fault

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe
from gpr20_simulator.mid.world.scene import InstrumentScene
from gpr20_survey.faults import NOT_CALIBRATED
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaReplacedError, VnaSettingError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect
from gpr20_vna_acquisition.mid.ms2026c import Ms2026c
from gpr20_vna_acquisition.mid.request_deadline import RequestDeadline
from gpr20_vna_acquisition.mid.vna_driver import VNADriver
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

CONFIRMATION = [":TRAC:PRE? 1", ":CALC1:DATA? SDAT", ":SENS:CORR:COLL:STAT:ACC?"]
HOST = "127.0.0.1"
LIMITS = LinkLimits(connect_s=1.0, answer_s=1.0)


def test_three_messages_confirm_a_sweep_and_four_take_it():
    bench = Bench().configured()
    for _ in range(3):
        del bench.vna.sent[:]
        number, _sweep = bench.driver.take_sweep()
        assert bench.vna.sent == [":INIT:IMM", ":STAT:OPER?", ":STAT:OPER?", ":CALC1:DATA? SDAT"]
        del bench.vna.sent[:]
        bench.driver.confirm(number)
        assert bench.vna.sent == CONFIRMATION


@each_case(
    "name, asked",
    [
        ("TRACE_1_STOP_FREQ", ":SENS:FREQ:STOP?"),
        ("IFBW", ":SENS:SWE:IFBW?"),
        ("S_TYPE", ":SENS:TRACE1:SPAR?"),
        ("DOMAIN", ":SENS:TRACE1:DOM?"),
    ],
)
def test_what_a_preamble_does_not_say_is_asked_for(name, asked):
    bench = Bench()
    bench.vna.left_out = name
    bench.configured()
    del bench.vna.sent[:]
    number, _sweep = bench.driver.take_sweep()
    bench.driver.confirm(number)
    assert asked in bench.vna.sent
    number, _sweep = bench.driver.take_sweep()
    bench.vna.settings[asked[:-1]] = "17"
    with raises_fault(faults.SETTINGS_CHANGED, error=VnaSettingError):
        bench.driver.confirm(number)


@each_case("answers", [True, False])
def test_another_instrument_on_the_same_link_is_noticed(answers):
    bench = Bench()
    if not answers:
        bench.vna.unanswered = [":TRAC:PRE? 1"]
    bench.configured()
    number, _sweep = bench.driver.take_sweep()
    bench.vna.preamble["SN"] = "7654321"
    bench.vna.identity = '"Anritsu,MS2026C/2,7654321,1.23"'
    with raises_fault(faults.REPLACED, 7654321, 1234567, error=VnaReplacedError):
        bench.driver.confirm(number)
    with raises_fault(faults.REPLACED, 7654321, 1234567):
        bench.driver.take_sweep()


def test_the_temperature_of_the_instrument_is_in_quarters_of_a_degree():
    bench = Bench().configured()

    def temperature_c():
        number, _sweep = bench.driver.take_sweep()
        return bench.driver.confirm(number).temperature_c

    assert temperature_c() == 40.75
    bench.vna.preamble["CURRENT_TEMPERATURE"] = "-6"
    assert temperature_c() == -1.5
    # It is valid only with a calibration, and 0 is how the instrument says that it is applied.
    bench.vna.preamble["CAL_CORRECTION"] = "1"
    assert temperature_c() is None


@each_case("name, value", [("SMOOTHING_PERCENT", "5.0"), ("TRACE_MATH_TYPES", "1")])
def test_a_trace_that_the_instrument_processes_is_refused(name, value):
    bench = Bench()
    bench.vna.preamble[name] = value
    with raises_fault(faults.PROCESSED, error=VnaSettingError):
        bench.configured()
    bench.vna.preamble[name] = "0"
    bench.configured()
    number, _sweep = bench.driver.take_sweep()
    bench.vna.preamble[name] = value
    with raises_fault(faults.SETTINGS_CHANGED, name, error=VnaSettingError):
        bench.driver.confirm(number)


def test_a_calibration_without_s21_is_none():
    bench = Bench()
    bench.vna.calibrated = "1"
    bench.driver.connect_to_vna(ADDRESS)
    status = bench.driver.check_calibration_status()
    assert status is CalibrationStatus.NONE
    refusal = bench.driver.calibration_refusal(status)
    assert refusal.fault == NOT_CALIBRATED and "S11" in str(refusal)
    bench.vna.calibrated = "5"
    assert bench.driver.check_calibration_status() is CalibrationStatus.HIGH


def test_a_calibration_is_described_as_far_as_the_instrument_says():
    bench = Bench()
    bench.driver.connect_to_vna(ADDRESS)
    bench.driver.check_calibration_status()
    assert bench.driver.state.calibration_details == {
        "parameters": ["S11", "S12", "S21", "S22"],
        "type": "2PFP",
        "interpolated": False,
        "is_corrected": True,
        "temperature_c": 40.75,
        "smoothing_percent": 0,
        "trace_math": 0,
    }
    bench.vna.unanswered = [":SENS:CAL:STAT?", ":SENS:CORR:COLL:TYPE?", ":SENS:CORR:COLL:INT?"]
    bench.driver.connect_to_vna(ADDRESS)
    assert bench.driver.check_calibration_status() is CalibrationStatus.HIGH
    assert set(bench.driver.state.calibration_details) == {
        "is_corrected",
        "temperature_c",
        "smoothing_percent",
        "trace_math",
    }


def test_a_sweep_that_was_begun_again_is_remarked():
    bench = Bench(max_level_db=60.0)
    bench.vna.sweep_s = 0.175
    bench.configured()
    bench.driver.get_trace()
    bench.vna.sweep_s = 1.5 * 0.175
    (remark,) = bench.driver.get_trace().quality
    assert "put back" in remark
    bench.vna.sweep_s = 0.175
    assert bench.driver.get_trace().quality == ()


@pytest.fixture
def vna() -> Iterator[SimulatedAnalyzer]:
    options = AnalyzerOptions(seconds_per_point=350e-6)
    place = AntennaPosition(1.0, 0.0, 0.0)
    one = SimulatedAnalyzer(PositionProbe(), lambda: place, Clock(), InstrumentScene(), options)
    one.start()
    yield one
    one.stop()


def driver_of(vna: SimulatedAnalyzer, points: int = 501) -> VNADriver:
    values = VnaParameters(display_settle_s=0.0, max_level_db=60.0, same_points=4001, attempts=2)
    deadline = RequestDeadline(Clock())
    analyzer = Ms2026c(lambda address: connect(address, LIMITS, vna.server.port), values, deadline)
    driver = VNADriver(analyzer, values, deadline, lambda _text: None)
    driver.connect_to_vna(HOST)
    driver.set_frequency_sweep(SweepSettings(600e6, 6e9, points))
    return driver


def taken(driver: VNADriver) -> Tuple[int, Tuple[str, ...]]:
    number, sweep = driver.take_sweep()
    return number, sweep.quality


def test_the_simulated_instrument_tells_all_that_a_confirmation_needs(vna):
    driver = driver_of(vna)
    assert driver.confirm(taken(driver)[0]).temperature_c == 40.0
    vna.faults.set("SWAPPED")
    with raises_fault(faults.REPLACED, "SIMULATED-2"):
        driver.confirm(taken(driver)[0])


def test_a_setting_that_is_changed_and_put_back_within_a_sweep_is_remarked(vna):
    driver = driver_of(vna, points=1501)
    assert taken(driver)[1] == ()
    vna.faults.set("HAND_PUT_BACK", 1)
    number, quality = taken(driver)
    assert len(quality) == 1 and "put back" in quality[0]
    driver.confirm(number)


def test_no_other_program_can_use_the_instrument_until_it_is_released(vna):
    driver = driver_of(vna)
    other = connect(HOST, LIMITS, vna.server.port)
    with raises_fault(faults.LOCKED, error=VnaConnectionError):
        other.write(":INIT:CONT ON")
    with raises_fault(faults.LOCKED, error=VnaConnectionError):
        driver_of(vna)
    driver.disconnect_from_vna()
    other = connect(HOST, LIMITS, vna.server.port)
    other.lock()
    other.unlock()
    other.close()


def test_a_lost_link_leaves_no_lock(vna):
    driver = driver_of(vna)
    vna.faults.set("DROP", 1)
    number, _quality = taken(driver)
    driver.confirm(number)
    driver.disconnect_from_vna()
    deadline_s = time.monotonic() + 2.0
    while vna.server.link_count:
        assert time.monotonic() < deadline_s
    driver_of(vna).disconnect_from_vna()
