"""The parameters of an axis and the coordinates they define."""

import dataclasses
import math

from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from survey_examples import AXES

from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import CONFIGURATION, NOT_ALLOWED
from gpr20_common.mid.codec import record_from
from gpr20_survey.axes import AxisId, AxisParameters

X_PARAMETERS, Z_PARAMETERS = AXES[AxisId.X], AXES[AxisId.Z]


@each_case(
    "field, value, shown",
    [
        ("dir_pin", 9, ("dir_pin", 9)),
        ("step_pin", 13, ("dir_pin 13, step_pin 13",)),
        ("min_step", 0.006, ("min_step", 0.006)),
        ("max_coord", 0.001, (0.001,)),
        ("homing_backoff", 131.0, ("homing_backoff", "131 mm", 0.01, "130 mm")),
        ("step_size", 1e-300, ("step_size", "1e-300 mm", 1e-05, "360 mm")),
        ("delta_step", 1e300, ("delta_step", "1e+300 s", 1e-07, "1 s")),
        ("late_limit_s", 0.0016, ("late_limit_s", "0.0016 s", 2e-06, 0.0015)),
        ("gap_limit_s", 0.0001, ("gap_limit_s", "0.0001 s", 0.0005)),
        ("memory_file", "/var/lib/z", ("/var/lib/z", X_PARAMETERS.sensor_pin)),
        ("sensor_pin", None, ()),
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


@each_case("field, value", [("endstop_pull", "none"), ("memory_file", "z")])
def test_an_axis_without_endstop_has_nothing_of_one_and_its_memory_has_a_path(field, value):
    dataclasses.replace(Z_PARAMETERS, memory_file="/var/lib/gpr20/z_axis")
    # A path that is not absolute is none.
    with raises_fault(CONFIGURATION, field, error=InvalidValueError):
        dataclasses.replace(Z_PARAMETERS, **{field: value})


@given(st.integers(0, 65000))
def test_every_step_of_x_has_a_coordinate_that_leads_back_to_it(steps):
    # Also one whose quotient is not exact in binary, such as 0.29 or 90.01.
    coordinate = X_PARAMETERS.coordinate_of(steps)
    assert coordinate == float(f"{steps // 100}.{steps % 100:02d}")
    assert X_PARAMETERS.distance_steps(coordinate) == steps
