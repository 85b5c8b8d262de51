"""The controller that a robot's configuration names."""

from __future__ import annotations

from typing import Type, cast

from gpr20_axis_driver.controller import AxisController
from gpr20_axis_driver.mid.axis_driver import AxisDriver
from gpr20_axis_driver.mid.controller_motions import ControllerMotions
from gpr20_common.mid.extension import load_extension
from gpr20_survey.axes.axis_parameters import AxisParameters


def check_controller(parameters: AxisParameters) -> Type[AxisController]:
    """Return the class of the controller; it is not made yet.

    Raises:
        InvalidValueError: It cannot be imported, is no controller, or has other options.
    """
    name, options = parameters.controller, parameters.controller_options
    found = load_extension("controller", name, AxisController, 1, options)
    return cast(Type[AxisController], found)


def open_controller(parameters: AxisParameters) -> ControllerMotions:
    """Return the motions of the controller that the parameters name.

    Raises:
        InvalidValueError: See `check_controller`.
        AxisException: The controller cannot be reached.
    """
    controller = check_controller(parameters)
    return ControllerMotions(
        parameters, lambda axis: controller(axis, **parameters.controller_options)
    )


def controller_driver(parameters: AxisParameters, motions: ControllerMotions) -> AxisDriver:
    """Return the driver of an axis that a controller moves."""
    return AxisDriver(parameters, motions, motions.home)
