"""The configuration of other sensors is checked key by key."""

from __future__ import annotations

import math

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.records import record_from
from gpr20_survey.plan.sensors import Sensors

SOIL = {"name": "soil", "topic": "probe/soil", "message": "std_msgs/Float64", "field": "data"}


def made(**changes):
    values = {**SOIL, **changes}
    return record_from(Sensors, {"sensors": [values]}, "").sensors[0]


def test_four_keys_are_enough():
    sensor = made()
    assert (sensor.unit, sensor.required, sensor.longest_age_s) == ("", False, 5.0)
    assert sensor.is_plausible(-1e300)


@each_case("field", ["data", "a.b[0]", "temperature", "a[12].b.c[3]"])
def test_a_field_may_lie_inside_others(field):
    assert made(field=field).field == field


WRONG = {
    "name": ("Soil", "", "a" * 65, "vna_temperature"),
    "topic": ("~soil", "soil moisture", ""),
    "message": ("Float64", "std_msgs/msg/Float64"),
    "field": ("data[", "a..b", "__class__.x()"),
    "unit": ("u" * 33, "\n", 5),
    "longest_age_s": (0.0, math.nan, 1e9),
    "required": ("yes",),
    "low": (math.inf,),
    "high": (math.nan,),
    "higher": (1.0,),
}


@each_case("key, value", [(key, value) for key in WRONG for value in WRONG[key]])
def test_the_message_names_a_key_or_value_that_is_wrong(key, value):
    with pytest.raises(InvalidValueError) as caught:
        made(**{key: value})
    message = caught.value.message
    assert message.fault_code in ("config.value_not_allowed", "value.not_allowed")
    values = [str(one) for inner in message.nested() for one in inner.values.values()]
    if key in ("unit", "low", "high") and message.fault_code == "config.value_not_allowed":
        assert SOIL["name"] in values and any(repr(value).strip("'") in one for one in values)
    else:
        assert any(key in one for one in values)


def test_low_is_below_high():
    assert made(low=1.0, high=2.0).is_plausible(1.0)
    for low, high in ((2.0, 1.0), (1.0, 1.0)):
        with raises_fault("config.value_not_allowed", "soil", error=InvalidValueError):
            made(low=low, high=high)


@each_case("key", SOIL)
def test_a_key_that_is_missing_is_named(key):
    values = {name: value for name, value in SOIL.items() if name != key}
    with raises_fault("config.value_not_allowed", f"sensors[0]/{key}", error=InvalidValueError):
        record_from(Sensors, {"sensors": [values]}, "")


def test_names_are_unique_and_sensors_few():
    with raises_fault("config.value_not_allowed", "soil", error=InvalidValueError):
        record_from(Sensors, {"sensors": [SOIL, SOIL]}, "")
    many = [{**SOIL, "name": f"s{number}"} for number in range(33)]
    with raises_fault("config.value_not_allowed", 33, 31, error=InvalidValueError):
        record_from(Sensors, {"sensors": many}, "")
