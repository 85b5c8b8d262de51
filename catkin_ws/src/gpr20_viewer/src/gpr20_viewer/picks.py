"""Places that an analyst has picked, with undo."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import List, Optional, Tuple

from gpr20_analysis.dataset import MM_PER_M
from gpr20_analysis.errors import AnalysisError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.radar import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY

NO_CLEARANCE_BY_PICKS = Message(
    "This is a list of picks, no clearance: ground without a pick is not free of mines."
)
"""Sentence that goes with every list of picks."""

SAME_PLACE_M = 0.005
"""Two picks of one polarization are at least this far apart, so a bounced click makes one."""


class PickRefusedError(AnalysisError, ValueError):
    """A pick cannot be made or changed like this."""

    fault = NOT_ALLOWED


@dataclass(frozen=True)
class Pick:
    """A place that an analyst has picked.

    Attributes:
        id: Name within its list, such as "P3"; the name of a deleted pick is not used again.
        x_m: Place along X [m].
        y_m: Place along Y [m].
        depth_m: Depth below the surface [m], as the permittivity gives it.
        polarization_deg: Rotation of the antennas [deg].
        permittivity: Relative permittivity with which the depth was read.
        permittivity_source: Where it is from: `slider`, or the source of an image's permittivity.
        level_db: Level of the image there, relative to its brightest voxel [dB]; None: unknown.
        note: What the analyst wrote.
        author: Who picked it; may be empty.
        time: When, ISO 8601, UTC.
    """

    id: str
    x_m: float
    y_m: float
    depth_m: float
    polarization_deg: float
    permittivity: float
    permittivity_source: str
    level_db: Optional[float]
    note: str = ""
    author: str = ""
    time: str = ""

    def __post_init__(self) -> None:
        """Check the values, which may come from a file.

        Raises:
            PickRefusedError: A value is not possible.
        """
        numbers = [self.x_m, self.y_m, self.depth_m, self.permittivity]
        numbers += [self.polarization_deg, *([] if self.level_db is None else [self.level_db])]
        is_possible = self.depth_m >= 0.0 and all(math.isfinite(one) for one in numbers)
        if not is_possible or not MIN_PERMITTIVITY <= self.permittivity <= LARGEST_PERMITTIVITY:
            raise PickRefusedError(
                Message(
                    "the pick {name} has the depth {depth_m:g} m and the permittivity "
                    "{permittivity:g}; a depth is not negative, a permittivity is 1 to 100, and "
                    "every number is finite",
                    name=self.id,
                    depth_m=self.depth_m,
                    permittivity=self.permittivity,
                )
            )


Picks = Tuple[Pick, ...]


class PickEditor:
    """The picks of a survey, and every earlier state of them.

    Attributes:
        next_number: Number of the next pick.
    """

    def __init__(self, picks: Picks = (), next_number: int = 1) -> None:
        self.next_number = max([next_number, *(_number_of(one) + 1 for one in picks)])
        self._states: List[Picks] = [picks]

    @property
    def picks(self) -> Picks:
        """The picks now."""
        return self._states[-1]

    def add(self, pick: Pick) -> Pick:
        """Add a pick under the next free name; return it.

        Raises:
            PickRefusedError: There is one at this place already.
        """
        for other in self.picks:
            if other.polarization_deg == pick.polarization_deg and _near(other, pick):
                raise PickRefusedError(
                    Message(
                        "{name} is already at this place; picks of one polarization are at least "
                        "{apart_mm:g} mm apart",
                        name=other.id,
                        apart_mm=SAME_PLACE_M * MM_PER_M,
                    )
                )
        named = replace(pick, id=f"P{self.next_number}")
        self.next_number += 1
        self._change((*self.picks, named))
        return named

    def remove(self, name: str) -> None:
        """Remove a pick."""
        self._change(tuple(one for one in self.picks if one.id != name))

    def set_note(self, name: str, note: str) -> None:
        """Write a note to a pick."""
        self._change(
            tuple(replace(one, note=note) if one.id == name else one for one in self.picks)
        )

    def undo(self) -> None:
        """Take the last change back, if there is one."""
        self._states[1:] = self._states[1:-1]

    def _change(self, picks: Picks) -> None:
        if picks != self.picks:
            self._states.append(picks)


def _number_of(pick: Pick) -> int:
    """Return the number in the name of a pick; 0 if it has another name."""
    digits = pick.id[1:]
    return int(digits) if pick.id[:1] == "P" and digits.isdecimal() else 0


def _near(one: Pick, other: Pick) -> bool:
    apart = (one.x_m - other.x_m, one.y_m - other.y_m, one.depth_m - other.depth_m)
    return math.sqrt(sum(part**2 for part in apart)) < SAME_PLACE_M
