"""A place in the ground that all views show, and the delay of its echo."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import HEIGHT, SAMPLE_DIMS, X, Y
from gpr20_analysis.processing.delay import ADVANCE
from gpr20_survey.radar import one_way_delay_s, two_way_delay_s


@dataclass(frozen=True)
class Place:
    """A place in the ground.

    Attributes:
        x_m: Along X [m].
        y_m: Along Y [m].
        depth_m: Below the surface [m].
    """

    x_m: float
    y_m: float
    depth_m: float


@dataclass(frozen=True)
class Line:
    """The traces of one polarization along a line: where they were taken, without gaps.

    Attributes:
        along: "x" or "y".
        position_m: Positions along the line [m].
        other_m: Position of the line on the other axis [m].
        height_m: Height of the antennas at each position; the mean where it is unknown [m].
        rotation_deg: Rotation of the antennas [deg].
        advance_s: What the step time_zero has taken from the delays [s].
        delay_s: Delay of cables and antennas [s].
    """

    along: str
    position_m: np.ndarray
    other_m: float
    height_m: np.ndarray
    rotation_deg: float
    advance_s: np.ndarray
    delay_s: float = 0.0

    def delays_s(self, place: Place, permittivity: float, separation_m: float) -> np.ndarray:
        """Return the two-way delay of an echo from a place at each position [s].

        Args:
            place: Where the echo comes from.
            permittivity: Relative permittivity of the soil.
            separation_m: Distance between the two antennas, along their rotation [m].
        """
        across_m = np.full_like(self.position_m, self.other_m)
        x_m, y_m = (self.position_m, across_m) if self.along == X else (across_m, self.position_m)
        turn, apart_m = np.radians(self.rotation_deg), separation_m / 2.0
        total = self.delay_s - self.advance_s
        for side in (1.0, -1.0):
            distance_m = np.hypot(
                x_m + side * apart_m * np.cos(turn) - place.x_m,
                y_m + side * apart_m * np.sin(turn) - place.y_m,
            )
            total = total + one_way_delay_s(self.height_m, place.depth_m, distance_m, permittivity)
        return np.asarray(total)

    def surface_delays_s(self, separation_m: float) -> np.ndarray:
        """Return the two-way delay of the surface below each position [s]."""
        down_m = np.hypot(self.height_m, separation_m / 2.0)
        return np.asarray(two_way_delay_s(down_m) + self.delay_s - self.advance_s)

    def depth_m(
        self, at_m: float, delay_s: float, permittivity: float, separation_m: float,
        deepest_m: float,
    ) -> float:  # fmt: skip
        """Return the depth straight below a position whose echo has a delay, 0 to the deepest."""
        nearest = int(np.argmin(np.abs(self.position_m - at_m)))
        part = slice(nearest, nearest + 1)
        one = replace(
            self,
            position_m=self.position_m[part],
            height_m=self.height_m[part],
            advance_s=self.advance_s[part],
        )
        x_m, y_m = (at_m, self.other_m) if self.along == X else (self.other_m, at_m)
        low, high = 0.0, deepest_m
        # The delay grows with the depth; 40 halvings leave less than a picometre.
        for _ in range(40):
            middle = (low + high) / 2.0
            delays_s = one.delays_s(Place(x_m, y_m, middle), permittivity, separation_m)
            low, high = (middle, high) if float(delays_s[0]) < delay_s else (low, middle)
        return (low + high) / 2.0


def line_of(
    survey: xr.Dataset,
    turn: int,
    along: str,
    at_m: float,
    height_m: Optional[float],
    delay_s: float,
) -> Line:
    """Return the line of a survey that is nearest to a position.

    Args:
        survey: The survey.
        turn: Index of the polarization.
        along: "x" or "y".
        at_m: Position on the other axis [m].
        height_m: Height [m]; None: as recorded, and the mean where it is not.
        delay_s: Delay of cables and antennas [s].
    """
    other = Y if along == X else X
    row = int(np.argmin(np.abs(survey[other].values - at_m)))
    heights_m = survey[HEIGHT].transpose(*SAMPLE_DIMS).isel({"polarization": turn, other: row})
    known_m = heights_m.values
    if height_m is None:
        recorded_m = survey[HEIGHT].values
        found_m = np.where(known_m > 0.0, known_m, np.mean(recorded_m[recorded_m > 0.0]))
    else:
        found_m = np.full_like(known_m, height_m)
    advance_s = np.zeros(known_m.shape)
    if ADVANCE in survey:
        taken = survey[ADVANCE].transpose(*SAMPLE_DIMS).isel({"polarization": turn, other: row})
        advance_s = np.nan_to_num(taken.values)
    return Line(
        along,
        survey[along].values.astype(np.float64),
        float(survey[other].values[row]),
        found_m,
        float(survey["polarization"].values[turn]),
        advance_s,
        delay_s,
    )
