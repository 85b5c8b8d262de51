"""Which value of another sensor belongs to a trace, and what happens without one."""

from __future__ import annotations

import json
import math

import pytest
from case_kit import each_case
from fake_robot import Bench, ManualClock, reports
from fault_kit import raises_fault

from gpr20_main_control.errors import DeviceError
from gpr20_main_control.mid.devices.described_robot import AuxSensors, SensorInput
from gpr20_survey.faults import SENSOR_FAILED
from gpr20_survey.plan.robot_description import Sensor
from gpr20_survey.plan.survey_state import SurveyState
from gpr20_survey.trace.trace import AuxValue

NOW_US = 1_790_000_000_000_000


@pytest.fixture
def clock():
    clock = ManualClock()
    clock.time_s, clock.set_s = 100.0, NOW_US / 1e6 - 100.0
    return clock


def sensor(**changes):
    fields = {"name": "soil", "topic": "probe", "message": "std_msgs/Float64", "field": "data"}
    return Sensor(**{**fields, "unit": "%", "longest_age_s": 2.0, "low": 0.0, **changes})


def sensors_with(clock, *received, **changes):
    """Return sensors of which the one has received values: (time [s], value)."""
    one = SensorInput(sensor(**changes), float, clock)
    for clock.time_s, value in received:
        one.note(value)
    return AuxSensors([one], clock)


def test_the_value_is_the_last_one_that_was_received_and_has_the_time_when_it_was(clock):
    sensors = sensors_with(clock, (101.0, 1.0), (102.0, 2.0))
    clock.time_s = 103.5
    values, remarks = sensors.for_trace()
    assert values == (AuxValue("soil", 2.0, "%", NOW_US + 2_000_000),)
    assert remarks == ()


@each_case(
    "value, stored, fault, shown",
    [
        (None, (), SENSOR_FAILED, "probe"),
        (math.nan, (), SENSOR_FAILED, "nan"),
        (math.inf, (), SENSOR_FAILED, "inf"),
        (-1.0, (-1.0,), SENSOR_FAILED, "-1 %"),
    ],
)
def test_a_sensor_that_fails_refuses_the_trace_or_leaves_a_remark_if_it_is_not_required(
    clock, value, stored, fault, shown
):
    received = [] if value is None else [(101.0, value)]
    values, (remark,) = sensors_with(clock, *received).for_trace()
    assert tuple(one.value for one in values) == stored
    assert "soil" in remark and shown in remark
    required = sensors_with(clock, *received, required=True)
    for ask in (required.for_trace, required.check_required):
        with raises_fault(fault, "soil", error=DeviceError):
            ask()


@each_case("step_us", [-(10**12), 0, 10**12])
def test_a_value_that_is_too_old_counts_as_silence_whatever_is_done_to_the_clock(clock, step_us):
    sensors = sensors_with(clock, (101.0, 1.0))
    clock.set_s += step_us / 1e6
    (value,), _remarks = sensors.for_trace()
    assert value.stamp_us == clock.time_of_day_us()
    clock.time_s = 103.0
    assert sensors.now()[0].problem is None
    clock.time_s = 103.1
    assert reports(sensors.now()[0].message, SENSOR_FAILED, "soil", "probe", 2.0)
    assert sensors.for_trace()[0] == ()


def test_a_survey_pauses_without_a_required_sensor_and_not_without_another():
    clock = ManualClock()
    needed, other = (
        SensorInput(sensor(name=name, longest_age_s=3600.0, required=name == "soil"), float, clock)
        for name in ("soil", "air")
    )
    bench = Bench(sensors=AuxSensors([needed, other], clock))

    def publish(value):
        needed.note(value)
        # Older than any sweep.
        clock.time_s += 100.0

    bench.start()
    bench.wait_for(SurveyState.FAILED)
    assert bench.storage.records == []
    publish(0.25)
    bench.start()
    bench.wait_for_visited(3)
    publish(math.nan)
    bench.wait_for(SurveyState.PAUSED)
    assert reports(bench.board.status.message, SENSOR_FAILED, "soil")
    publish(0.5)
    bench.resume_to_the_end()
    assert {s.aux[0].value for s in bench.storage.samples} == {0.25, 0.5}
    ((remark,),) = {s.quality for s in bench.storage.samples}
    assert "air" in remark
    recorded, _other = json.loads(bench.storage.records[0].metadata_json)["sensors"]
    assert (recorded["name"], recorded["unit"], recorded["required"]) == ("soil", "%", True)
