"""The simulated height sensor, and the states that parts share."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import numpy as np
import pytest
from case_kit import each_case
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.low.clock import Clock
from gpr20_height_sensor.adc_interface import AdcInterface
from gpr20_height_sensor.height_driver import HeightDriver, HeightParameters
from gpr20_simulator.low import shared_state
from gpr20_simulator.low.shared_state import GRACE_S, AdcFault, remove_stale_states
from gpr20_simulator.mid.world.range_sensor import RangeSensor, SimulatedSpi, sensor_voltage_v
from gpr20_simulator.mid.world.scene import Adc
from gpr20_survey.axes import AxisId


class NoClock(Clock):
    def sleep_until_s(self, deadline_s):
        pass

    def wait_s(self, event, timeout_s):
        return event.is_set()


def test_the_output_is_that_of_the_data_sheet():
    assert sensor_voltage_v(0.80) == pytest.approx(0.4)
    assert sensor_voltage_v(0.10) == pytest.approx(2.3)
    # It falls on both sides of its peak.
    distances_m = np.linspace(0.0, 1.5, 301)
    voltages_v = np.array([sensor_voltage_v(d) for d in distances_m])
    peak = int(voltages_v.argmax())
    assert 0.05 < distances_m[peak] < 0.10 and voltages_v[peak] <= 3.1
    assert (np.diff(voltages_v[: peak + 1]) > 0).all() and (np.diff(voltages_v[peak:]) < 0).all()


@each_case("height_m", [0.12, 0.20, 0.30, 0.40])
def test_the_driver_finds_the_true_height_within_5_mm(height_m):
    sensor = RangeSensor(Adc(), lambda: height_m, lambda: AdcFault.NONE)
    adc = AdcInterface(SimulatedSpi(sensor.code), 0)
    driver = HeightDriver(adc, HeightParameters(), NoClock(), lambda: 0)
    assert driver.take_measurement().height_m == pytest.approx(height_m, abs=0.005)


@given(st.integers(0, 1023), st.integers(0, 7))
def test_the_driver_reads_the_code_of_the_channel_it_asks_for(code, channel):
    spi = SimulatedSpi(lambda asked: code if asked == channel else 1023 - code)
    assert AdcInterface(spi, channel).read_code() == code


def test_a_faster_clock_lets_as_many_seconds_pass_in_one_of_the_computer(monkeypatch):
    waited_s = []
    monkeypatch.setattr(shared_state.time, "monotonic", lambda: 3.0)
    monkeypatch.setattr(shared_state.time, "sleep", waited_s.append)
    clock = shared_state.ScaledClock(50.0)
    clock.sleep_until_s(clock.now_s() + 25.0)
    assert (clock.now_s(), waited_s) == (150.0, [0.5])


# The states of launches that have ended are cleared away; those that are in use never.

STATE, OTHER = "0" * 32, "f" * 32
OPEN_AND_WAIT = """
import sys, pathlib
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_survey.axes import AxisId
state = open_shared_state(pathlib.Path(sys.argv[1]), {axis: 0 for axis in AxisId})
print("open", flush=True)
sys.stdin.read()
"""


@pytest.fixture
def folder(tmp_path):
    """The states of two launches, with the step memories of their axes."""
    for name in (STATE, OTHER):
        for axis in AxisId:
            (tmp_path / f"{name}_{axis.value}_steps").write_bytes(b"steps")
    (tmp_path / f"{STATE}.txt").write_text("somebody else's")
    return tmp_path


def grow_old(folder):
    for path in folder.iterdir():
        old_s = time.time() - 2 * GRACE_S
        os.utime(str(path), (old_s, old_s))


def test_a_state_that_a_process_has_open_is_kept_until_that_process_is_killed(folder):
    command = [sys.executable, "-c", OPEN_AND_WAIT, str(folder / STATE)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as owner:
        assert owner.stdout.readline() == b"open\n"
        grow_old(folder)
        remove_stale_states(folder)
        assert {path.name[:32] for path in folder.iterdir()} == {STATE}
        owner.kill()
        owner.wait()
    remove_stale_states(folder)
    assert [path.name for path in folder.iterdir()] == [f"{STATE}.txt"]


def test_a_state_that_was_just_made_is_kept(folder):
    remove_stale_states(folder)
    assert len(list(folder.iterdir())) == 7
    remove_stale_states(folder / "missing")
