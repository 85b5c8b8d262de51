"""The parameters of an axis and the coordinates they define."""

import dataclasses
import math

from axis_machine import X_PARAMETERS, Z_PARAMETERS
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.mid.codec import record_from
from gpr20_survey.axes.axis_parameters import AxisParameters


@each_case(
    "field, value, shown",
    [
        ("dir_pin", 9, ("dir_pin", 9)),
        ("step_pin", 13, ("dir_pin 13, step_pin 13",)),
        ("step_size", 0.0, ("step_size", 0)),
        ("min_step", 0.006, ("min_step", 0.006)),
        ("max_step", math.inf, ("max_step", "inf")),
        ("max_coord", 0.001, (0.001,)),
        ("type", "LINEAR", ("type", "'LINEAR'")),
        ("homing_backoff", 131.0, ("homing_backoff", "131 mm", 0.01, "130 mm")),
        ("step_size", 1e-300, ("step_size", "1e-300 mm", 1e-05, "360 mm")),
        ("delta_step", 1e300, ("delta_step", "1e+300 s", 1e-07, "1 s")),
        ("late_limit_s", 0.0016, ("late_limit_s", "0.0016 s", 2e-06, 0.0015)),
        ("gap_limit_s", 0.0001, ("gap_limit_s", "0.0001 s", 0.0005)),
        ("memory_file", "/var/lib/z", ("/var/lib/z", X_PARAMETERS.sensor_pin)),
        ("sensor_pin", None, ()),
        ("endstop_active", "High", ("endstop_active", "'High'", "low, high")),
        ("enable_active", "high", ("enable_active is high", "no enable_pin")),
        ("enable_pin", 16, ("sensor_pin 16, enable_pin 16",)),
        *(("controller", odd, ()) for odd in ("os.system", "a:b:c", "../x:C")),
        ("homing_margin", math.nan, ("homing_margin", "nan")),
    ],
)
def test_a_wrong_parameter_is_refused_by_name(field, value, shown):
    values = {**dataclasses.asdict(X_PARAMETERS), field: value}
    with raises_fault((NOT_ALLOWED, CONFIGURATION), *shown, error=InvalidValueError):
        record_from(AxisParameters, values, "x_axis")


# A path that is not absolute is none.
@each_case(
    "field, value, shown", [("endstop_pull", "none", "no sensor_pin"), ("memory_file", "z", "z")]
)
def test_an_axis_without_endstop_has_nothing_of_one_and_its_memory_has_a_path(field, value, shown):
    dataclasses.replace(Z_PARAMETERS, memory_file="/var/lib/gpr20/z_axis")
    with raises_fault(CONFIGURATION, field, shown, error=InvalidValueError):
        dataclasses.replace(Z_PARAMETERS, **{field: value})


@given(st.integers(0, 65000))
def test_every_step_of_x_has_a_coordinate_that_leads_back_to_it(steps):
    coordinate = X_PARAMETERS.coordinate_of(steps)
    assert X_PARAMETERS.distance_steps(coordinate) == steps
    # The float nearest to its decimal value.
    assert coordinate == float(f"{steps // 100}.{steps % 100:02d}")


@each_case("target, steps", [(0.29, 29), (0.57, 57), (90.01, 9001), (649.99, 64999)])
def test_a_target_whose_quotient_is_not_exact_in_binary_loses_no_step(target, steps):
    assert X_PARAMETERS.distance_steps(target) == steps
