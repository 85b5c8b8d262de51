"""A candidate, and the list of all candidates of a survey."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from typing import Optional, Tuple

from gpr20_common.message import Message

# As a name of this module too: it belongs to every list.
from gpr20_survey.no_clearance import NO_CLEARANCE as NO_CLEARANCE


class Flag(enum.Enum):
    """What an analyst should know before believing a candidate."""

    SURFACE_RESIDUE = "surface-residue"
    """So shallow that it may be the rest of the surface echo."""
    EDGE = "edge"
    """So near to the edge of the surveyed area that it may lie outside of it."""
    ONE_POLARIZATION = "one-polarization"
    """Seen in one polarization only, although both were measured."""
    CLUTTER = "clutter"
    """Not brighter than what the whole area shows at its depth, as the rest of the surface echo or
    a layer does."""
    SIDELOBE = "sidelobe"
    """So much fainter than a candidate near it that it may be a sidelobe of that one."""
    UNRATED = "unrated"
    """The noise could not be measured, so it may be noise."""


SECONDARY = frozenset({Flag.CLUTTER, Flag.SIDELOBE})
"""Candidates with these flags come after all others."""
OMITTED = SECONDARY | {Flag.UNRATED}
"""Only candidates with one of these flags are omitted from a list that would be too long."""


@dataclass(frozen=True)
class Candidate:
    """A place where the image is brighter than noise.

    Uncertainties are standard deviations, except that the depth contains the range of the
    permittivity.

    Attributes:
        id: Name within its list: "C01" is the first.
        x_m: Place along X [m].
        y_m: Place along Y [m].
        depth_m: Depth below the surface [m].
        x_uncertainty_m: Uncertainty along X [m].
        y_uncertainty_m: Uncertainty along Y [m].
        depth_uncertainty_m: Uncertainty of the depth from permittivity, picking and height [m].
        above_noise_db: Level above the standard magnitude of noise at this place [dB]; NaN if the
            noise could not be measured.
        false_alarm_probability: Probability that noise alone has a voxel as bright as this
            anywhere in the image, 0 to 1; 1 if the noise could not be measured.
        rotations_deg: Rotations of the antennas at which it is brighter than noise, the one where
            it is brightest first [deg]; NaN for a combination of polarizations.
        polarization_ratio_db: Level at the first rotation above that at the second [dB]; None if
            only one polarization was measured.
        flags: What to know before believing it.
    """

    id: str
    x_m: float
    y_m: float
    depth_m: float
    x_uncertainty_m: float
    y_uncertainty_m: float
    depth_uncertainty_m: float
    above_noise_db: float
    false_alarm_probability: float
    rotations_deg: Tuple[float, ...]
    polarization_ratio_db: Optional[float]
    flags: Tuple[Flag, ...]

    @property
    def is_secondary(self) -> bool:
        """Whether it may be only clutter, or a sidelobe of a brighter candidate."""
        return bool(SECONDARY & set(self.flags))

    @property
    def confidence(self) -> float:
        """Probability that noise alone has no voxel as bright as this, 0 to 1."""
        return 1.0 - self.false_alarm_probability


@dataclass(frozen=True)
class AreaPosition:
    """Where the survey's area is on the earth.

    Attributes:
        latitude_deg: WGS 84 latitude of the origin of X and Y [deg], north positive.
        longitude_deg: WGS 84 longitude of the origin [deg], east positive.
        heading_deg: Direction of +Y, clockwise from north [deg]; +X is 90 degrees to its right.
    """

    latitude_deg: float
    longitude_deg: float
    heading_deg: float


@dataclass(frozen=True)
class CandidateList:
    """The candidates of a survey and how they were found.

    The brightest comes first, but those that are `SECONDARY` come after all others.

    Attributes:
        survey_id: Identifier of the survey; empty if the data have none.
        simulated: Whether the survey was made by the simulated robot.
        method: Imaging method.
        permittivity: Relative permittivity of the image.
        permittivity_range: Lowest and highest possible value; equal if it was given.
        area_m2: Surveyed area [m^2].
        false_alarm_rate: Largest false-alarm probability of a listed candidate.
        omitted: Number of candidates beyond the longest list, the last ones; each has a flag of
            `OMITTED`.
        candidates: The candidates.
        notes: What was left out or may be wrong.
        position: Place of the origin of X and Y on the earth and direction of Y; None if the survey
            has no position or no heading.
        omitted_primary: Number of omitted candidates that are not `SECONDARY`.
    """

    survey_id: str
    simulated: bool
    method: str
    permittivity: float
    permittivity_range: Tuple[float, float]
    area_m2: float
    false_alarm_rate: float
    omitted: int
    candidates: Tuple[Candidate, ...]
    notes: Tuple[Message, ...] = ()
    position: Optional[AreaPosition] = None
    omitted_primary: int = 0
