"""What the daily check of the radar sweeps, and what it asks for."""

from __future__ import annotations

import enum

from gpr20_common.message import Message


class Part(enum.Enum):
    """What the antennas see, numbered as in gpr20_msgs/DailyCheck."""

    EMPTY = "empty"
    PLATE = "plate"
    REFLECTOR = "reflector"


INSTRUCTIONS = {
    Part.EMPTY: Message(
        "Empty sweep: let the antennas see the sky or an absorber, and nothing else within 2 m."
    ),
    Part.PLATE: Message("Metal plate: put it below the antennas, at its mark."),
    Part.REFLECTOR: Message("Known reflector: take the plate away and put it at its mark."),
}
