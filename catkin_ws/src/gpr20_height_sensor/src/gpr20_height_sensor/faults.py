"""The faults of the height sensor."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault, Message

SENSOR_OFF = Fault(
    "height.sensor_off", Message("Check the plug and the supply of the height sensor.")
)
SENSOR_FROZEN = Fault(
    "height.sensor_frozen",
    Message(
        "Put a hand under the height sensor. If its value changes, let the person who maintains "
        "the robot raise frozen_readings; if not, replace the sensor."
    ),
)
OUT_OF_RANGE = Fault(
    "height.out_of_range",
    Message(
        "Check the height of the antennas. Remove grass or objects below the height sensor, so "
        "that it sees the ground."
    ),
)
NOISY = Fault(
    "height.noisy",
    Message("Check the supply of the height sensor, and that the antennas do not move."),
)
CONVERTER_FAILED = Fault(
    "height.converter_failed",
    Message("Check the plug, the wiring and the supply of the height sensor's converter."),
)
NO_SPI_LIBRARY = Fault("height.no_spi_library", remedies.INSTALL_ROBOT)
# Permission and files of a device are no matter of the data disk.
SPI_REFUSED = Fault(
    "height.spi_refused",
    Message(
        "Ask the person who maintains the robot to enable SPI and to allow the robot's user to use "
        "it."
    ),
)
SHUTTING_DOWN = Fault("height.shutting_down", remedies.WAIT_FOR_PART)
