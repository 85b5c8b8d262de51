"""A recorder in place of the module RPi.GPIO, which accepts what version 0.7.1 accepts.

Names, order and defaults of the arguments, the numbers of the constants and the refusals are those
of its source (py_gpio.c, constants.h). `input` and `output` take no keywords there.
"""

from __future__ import annotations

from typing import Any, Dict, List, Tuple

BOARD, BCM = 10, 11
OUT, IN = 0, 1
LOW, HIGH = 0, 1
PUD_OFF, PUD_DOWN, PUD_UP = 20, 21, 22


class RecordedRpiGpio:
    """Records the calls; a level can be given to an input."""

    BOARD, BCM, OUT, IN, LOW, HIGH = BOARD, BCM, OUT, IN, LOW, HIGH
    PUD_OFF, PUD_DOWN, PUD_UP = PUD_OFF, PUD_DOWN, PUD_UP

    def __init__(self) -> None:
        self.calls: List[Tuple[Any, ...]] = []
        self.levels: Dict[int, int] = {}
        self.directions: Dict[int, int] = {}
        self.inputs: Dict[int, int] = {}
        self.mode: int = -1

    def setmode(self, mode, /):
        if mode not in (BOARD, BCM):
            raise ValueError("An invalid mode was passed to setmode()")
        if self.mode not in (-1, mode):
            raise ValueError("A different mode has already been set!")
        self.mode = mode
        self.calls.append(("setmode", mode))

    def setup(self, channel, direction, pull_up_down=PUD_OFF, initial=-1):
        assert self.mode == BOARD, "Please set pin numbering mode using GPIO.setmode(GPIO.BOARD)"
        if not all(isinstance(one, int) for one in (channel, direction, pull_up_down, initial)):
            raise TypeError("an integer is required")
        if direction == OUT and pull_up_down != PUD_OFF:
            raise ValueError("pull_up_down parameter is not valid for outputs")
        if direction == IN and initial != -1:
            raise ValueError("initial parameter is not valid for inputs")
        self.calls.append(("setup", channel, direction, pull_up_down, initial))
        self.directions[channel] = direction
        if initial in (LOW, HIGH):
            self.levels[channel] = initial

    def output(self, channel, value, /):
        if self.directions.get(channel) != OUT:
            raise RuntimeError("The GPIO channel has not been set up as an OUTPUT")
        self.calls.append(("output", channel, value))
        self.levels[channel] = int(value)

    def input(self, channel, /):
        if channel not in self.directions:
            raise RuntimeError("You must setup() the GPIO channel first")
        return self.inputs.get(channel, HIGH)

    def cleanup(self, channel=None):
        if not isinstance(channel, (int, list, tuple)):
            raise ValueError("Channel must be an integer or list/tuple of integers")
        self.calls.append(("cleanup", channel))
        for one in [channel] if isinstance(channel, int) else channel:
            self.directions.pop(one)
