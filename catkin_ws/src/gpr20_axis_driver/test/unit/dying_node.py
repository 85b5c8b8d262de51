"""A program that begins a turn of the z axis and is killed in the middle: see its test."""

import sys
from pathlib import Path

from simulated_axis import SimulatedAxis

from gpr20_axis_driver.motion import never
from gpr20_survey.axes.axis_id import AxisId

axis = SimulatedAxis(Path(sys.argv[1]), AxisId.Z, time_scale=1.0)
axis.driver.homing(never)
print(axis.pulses.process_id, flush=True)
axis.driver.move_to_coordinate(90.0, never)
