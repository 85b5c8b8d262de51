"""The candidates of a survey as records, and as the JSON of `gpr20 candidates --json`."""

from __future__ import annotations

import enum
import json
import math
from dataclasses import dataclass, field, replace
from typing import Any, Dict, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, received_message
from gpr20_common.mid.codec import bounded, plain, record_from

SEMI_MAJOR_AXIS_M = 6378137.0
ECCENTRICITY_2 = 0.00669437999014
"""WGS 84: equatorial radius, and square of the first eccentricity."""


@dataclass(frozen=True)
class AreaPosition:
    """WGS 84 position of the origin of X and Y, north and east positive.

    The heading is the direction of +Y, clockwise from north; +X is 90 degrees to its right.
    """

    latitude_deg: float = bounded(-90.0, 90.0)
    longitude_deg: float = bounded(-180.0, 180.0)
    heading_deg: float = bounded(-math.inf, math.inf)

    def on_earth(self, x_m: float, y_m: float) -> Tuple[float, float]:
        """Return WGS 84 longitude and latitude [deg] of a place of the area.

        The surface is taken as a plane, which is right within a millimetre over 10 m.
        """
        heading = math.radians(self.heading_deg)
        north_m = y_m * math.cos(heading) - x_m * math.sin(heading)
        east_m = y_m * math.sin(heading) + x_m * math.cos(heading)
        latitude = math.radians(self.latitude_deg)
        bulge = 1.0 - ECCENTRICITY_2 * math.sin(latitude) ** 2
        along_meridian_m = SEMI_MAJOR_AXIS_M * (1.0 - ECCENTRICITY_2) / bulge**1.5
        across_m = max(SEMI_MAJOR_AXIS_M / math.sqrt(bulge) * math.cos(latitude), 1.0)
        longitude_deg = self.longitude_deg + math.degrees(east_m / across_m)
        return (
            (longitude_deg + 180.0) % 360.0 - 180.0,
            self.latitude_deg + math.degrees(north_m / along_meridian_m),
        )


NO_CLEARANCE = Message(
    "This is a list of candidates, no clearance: ground without a candidate is not free of mines."
)
SIMULATED = Message("SIMULATED: these are no measurements of real ground.")
MM_PER_M = 1e3
# From where on an echo is called so [dB above the clutter around it].
STRONG_DB, CLEAR_DB = 25.0, 15.0


class Flag(enum.Enum):
    """What an analyst should know before believing a candidate."""

    SURFACE_RESIDUE = "surface-residue"
    """So shallow that it may be the rest of the surface echo."""
    EDGE = "edge"
    """So near to the edge of the surveyed area that it may lie outside of it."""
    ONE_POLARIZATION = "one-polarization"
    """Seen in one polarization only, although both were measured."""
    CLUTTER = "clutter"
    """No stronger than clutter is at the stated rate of false alarms."""
    SIDELOBE = "sidelobe"
    """So much fainter than a candidate near it that it may be left from that one."""
    BRIGHTEST = "brightest"
    """No stronger than clutter, but the brightest echo of the survey, which is always listed."""


LABELS = {
    Flag.SURFACE_RESIDUE: Message("surface residue"),
    Flag.EDGE: Message("edge"),
    Flag.ONE_POLARIZATION: Message("in one rotation only"),
    Flag.CLUTTER: Message("clutter"),
    Flag.SIDELOBE: Message("sidelobe"),
    Flag.BRIGHTEST: Message("only the brightest"),
}
DOUBTFUL = frozenset({Flag.CLUTTER, Flag.SIDELOBE})
"""Below the cut of the list: weaker echoes, which come after all places to check."""


CANDIDATE_ID = "C[0-9]{2,7}"
# The bounds of what is read, see `bounded`.
SIZE, PERMITTIVITY = {"ge": 0.0, "le": math.inf}, {"ge": 1.0, "le": math.inf}
COUNT = {"ge": 0, "le": 2**53}


@dataclass(frozen=True)
class Candidate:
    """A place where the image is stronger than the clutter around it.

    Uncertainties are standard deviations, except that the depth contains the range of the
    permittivity.

    Attributes:
        id: Name within its list: "C01" is the first.
        depth_uncertainty_m: Uncertainty of the depth from permittivity, picking and height [m].
        above_clutter_db: Level of its echoes together above the clutter around them [dB].
        rotations_deg: Rotations of the antennas at which it is seen, the one where it is strongest
            first [deg].
        polarization_ratio_db: Level at the first rotation above that at the second [dB]; None if
            only one polarization was measured.
    """

    id: str = field(metadata={"pattern": f"^{CANDIDATE_ID}$"})
    x_m: float
    y_m: float
    depth_m: float = field(metadata=SIZE)
    x_uncertainty_m: float = field(metadata=SIZE)
    y_uncertainty_m: float = field(metadata=SIZE)
    depth_uncertainty_m: float = field(metadata=SIZE)
    above_clutter_db: float
    rotations_deg: Tuple[float, ...]
    polarization_ratio_db: Optional[float]
    flags: Tuple[Flag, ...]

    @property
    def number(self) -> int:
        """Its place in the list, from 1."""
        return int(self.id[1:])

    @property
    def x_mm(self) -> float:
        return MM_PER_M * self.x_m

    @property
    def y_mm(self) -> float:
        return MM_PER_M * self.y_m

    @property
    def depth_mm(self) -> float:
        return MM_PER_M * self.depth_m

    @property
    def is_doubtful(self) -> bool:
        """Whether it is below the cut: it may be clutter, or a sidelobe of a brighter place."""
        return not DOUBTFUL.isdisjoint(self.flags)

    @property
    def labels(self) -> Tuple[Message, ...]:
        return tuple(LABELS[flag] for flag in self.flags)

    @property
    def place_texts(self) -> Tuple[str, str, str]:
        """X, Y and depth with their uncertainties, such as "174 ±4" [mm]."""
        x, y, depth = (
            # 2.00001 mm are 2 mm.
            f"{value_m * MM_PER_M:.0f} ±{math.ceil(round(uncertainty_m * MM_PER_M, 2))}"
            for value_m, uncertainty_m in (
                (self.x_m, self.x_uncertainty_m),
                (self.y_m, self.y_uncertainty_m),
                (self.depth_m, self.depth_uncertainty_m),
            )
        )
        return x, y, depth

    @property
    def strength(self) -> Message:
        """How strong it is, in words."""
        if self.above_clutter_db >= STRONG_DB:
            return Message("strong")
        return Message("clear") if self.above_clutter_db >= CLEAR_DB else Message("weak")


@dataclass(frozen=True)
class CandidateList:
    """The candidates of a survey and how they were found.

    First the places to check, then the weaker echoes; of each those first that are furthest above
    the clutter around them.

    Attributes:
        survey_id: Identifier of the survey; empty if the data have none.
        area_m2: Surveyed area [m^2]; that of a single line is a strip below it.
        false_alarms_per_m2: The rate of false alarms at which the list is cut [1/m^2].
        least_db: How far an echo must be above the clutter at that rate [dB].
        omitted: Number of weaker echoes that are not even listed, the last ones.
        notes: What was left out or may be wrong.
        position: Place of the origin of X and Y on the earth and direction of Y; None if the survey
            has no position or no heading.
        permittivity_source: Where the permittivity is from; empty: not known.
        length_m: Length of a single line [m]; None for an area.
    """

    survey_id: str
    simulated: bool
    method: str
    permittivity: float = field(metadata=PERMITTIVITY)
    permittivity_lowest: float = field(metadata=PERMITTIVITY)
    permittivity_highest: float = field(metadata=PERMITTIVITY)
    permittivity_source: str
    area_m2: float = field(metadata=SIZE)
    false_alarms_per_m2: float = field(metadata=SIZE)
    least_db: float
    omitted: int = field(metadata=COUNT)
    position: Optional[AreaPosition]
    candidates: Tuple[Candidate, ...]
    notes: Tuple[Message, ...] = ()
    length_m: Optional[float] = None

    @property
    def total(self) -> int:
        return len(self.candidates) + self.omitted

    @property
    def primary(self) -> int:
        """Number of places to check."""
        return len(self.shown())

    @property
    def weaker(self) -> int:
        """Number of weaker echoes, which people see who ask for them."""
        return self.total - self.primary

    def shown(self) -> Tuple[Candidate, ...]:
        """Return the places to check."""
        return tuple(one for one in self.candidates if not one.is_doubtful)


FORMAT = "gpr20-candidates/1"
"""Another flag, or another key that must be there, is another format."""


@dataclass(frozen=True)
class _Head:
    """What the JSON says beside the fields of the list.

    Attributes:
        warning: What has none is a list of another kind.
        note_faults: The notes with template and fault; lists of other programs have only texts.
    """

    format: str
    warning: str = field(metadata={"min_length": 1})
    listed: int
    notes: Tuple[str, ...]
    note_faults: Tuple[Any, ...] = ()


def json_text(found: CandidateList) -> str:
    """Return a list as JSON."""
    candidates = [candidate_record(one, found) for one in found.candidates]
    record = {**list_record(found), "candidates": candidates}
    return json.dumps(record, indent=2, ensure_ascii=False, allow_nan=False)


def list_record(found: CandidateList) -> Dict[str, Any]:
    values = plain(replace(found, candidates=(), notes=()))
    del values["candidates"], values["length_m"]
    return {
        "format": FORMAT,
        "warning": str(NO_CLEARANCE),
        **({"simulated_warning": str(SIMULATED)} if found.simulated else {}),
        **values,
        "listed": len(found.candidates),
        "coordinates": "X, Y and depth in metres, in the survey's area",
        "notes": [str(note) for note in found.notes],
        # With template and fault, for other programs of the robot.
        "note_faults": [note.record() for note in found.notes],
    }


def candidate_record(candidate: Candidate, found: CandidateList) -> Dict[str, Any]:
    """Return the values of a candidate; None for what is not known."""
    place = found.position and found.position.on_earth(candidate.x_m, candidate.y_m)
    longitude_deg, latitude_deg = place or (None, None)
    earth = {"longitude_deg": longitude_deg, "latitude_deg": latitude_deg}
    return {**plain(candidate), "doubtful": candidate.is_doubtful, **earth}


def list_from(text: str, survey_id: Optional[str] = None) -> CandidateList:
    """Return the list that a command printed.

    Args:
        text: What it printed.
        survey_id: The survey that it was asked about; None: any.

    Raises:
        InvalidValueError: Something is missing, or has another type, format or survey.
    """
    try:
        values = json.loads(text)
        head = record_from(_Head, values, "", others=True)
        found = record_from(CandidateList, {**values, "notes": []}, "", others=True)
        note_faults = head.note_faults or [None] * len(head.notes)
        for name, right in {
            f"format {head.format}": head.format == FORMAT,
            "listed": head.listed == len(found.candidates),
            "id": len({one.id for one in found.candidates}) == len(found.candidates),
            "note_faults": len(head.notes) == len(note_faults),
            "survey_id": survey_id in (None, found.survey_id),
        }.items():
            if not right:
                raise ValueError(f"wrong {name}")
    except (ValueError, RecursionError) as error:
        message = Message("the list of candidates is not complete or not valid", details=error)
        raise InvalidValueError(message) from error
    return replace(found, notes=tuple(map(received_message, head.notes, note_faults)))
