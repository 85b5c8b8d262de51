"""Targets that could be hidden in the ground: plastic discs such as mines, and metal balls."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.checks import number_between

MM_PER_M = 1e3
SMALLEST_MM, LARGEST_MM, HIGHEST = 5.0, 400.0, 100.0
MOST_SHOWN = 40
EXPLOSIVE = 2.8
"""Relative permittivity of a plastic mine: that of TNT, which fills most of it, is 2.7 to 2.9."""


@dataclass(frozen=True)
class Target:
    """A level disc of plastic, or a ball of metal.

    Attributes:
        height_m: Its height [m]; of a ball its diameter.
        permittivity: Its relative permittivity; None: it is metal.
    """

    name: str
    diameter_m: float
    height_m: float
    permittivity: Optional[float] = None

    def __post_init__(self) -> None:
        for name, size_m in (("diameter", self.diameter_m), ("height", self.height_m)):
            number_between(name, MM_PER_M * size_m, SMALLEST_MM, LARGEST_MM, "mm")
        if self.permittivity is not None:
            number_between("permittivity", self.permittivity, 1.0, HIGHEST)

    @property
    def is_metal(self) -> bool:
        return self.permittivity is None

    @property
    def sentence(self) -> Message:
        diameter_mm, height_mm = MM_PER_M * self.diameter_m, MM_PER_M * self.height_m
        if self.is_metal:
            return Message("a metal ball of {diameter_mm:g} mm", diameter_mm=diameter_mm)
        return Message(
            "a plastic disc of {diameter_mm:g} mm, {height_mm:g} mm high, relative permittivity "
            "{permittivity:g}",
            diameter_mm=diameter_mm,
            height_mm=height_mm,
            permittivity=self.permittivity,
        )


class Targets(enum.Enum):
    """Targets with a name. The sizes of the mines are those of their data sheets."""

    PMN = Target("pmn", 0.112, 0.056, EXPLOSIVE)
    TYPE_72 = Target("type-72", 0.078, 0.038, EXPLOSIVE)
    FRAGMENT = Target("fragment", 0.020, 0.020)


def target_of(text: str) -> Target:
    """Return a target from its name, or from disc:DIAMETER:HEIGHT:PERMITTIVITY or ball:DIAMETER.

    Args:
        text: Sizes are in mm.

    Raises:
        InvalidValueError: It is none of these, or a value is not allowed.
    """
    named = {one.value.name: one.value for one in Targets}
    if text in named:
        return named[text]
    kind, *sizes = text.split(":")
    try:
        numbers = [float(one) for one in sizes]
    except ValueError:
        numbers = []
    if (kind, len(numbers)) == ("disc", 3):
        diameter_mm, height_mm, permittivity = numbers
        return Target(text[:MOST_SHOWN], diameter_mm / MM_PER_M, height_mm / MM_PER_M, permittivity)
    if (kind, len(numbers)) == ("ball", 1):
        return Target(text[:MOST_SHOWN], numbers[0] / MM_PER_M, numbers[0] / MM_PER_M)
    raise InvalidValueError(
        Message(
            "the target is '{text}'; use {names}, disc:DIAMETER:HEIGHT:PERMITTIVITY or "
            "ball:DIAMETER, sizes in mm, such as disc:80:35:2.8",
            text=text[:MOST_SHOWN],
            names=", ".join(named),
        )
    )
