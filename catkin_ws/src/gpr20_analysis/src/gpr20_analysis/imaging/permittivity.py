"""The permittivity of an image: the best source that there is, and what depths are worth by it.

The echo of an object that was buried at a known depth gives it. It is looked for in an image, for
which the permittivity need not be known: with the delay of an echo's apex given, its delays at the
other positions depend little on it. So the image has it at a depth times the refractive index.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Dict, List, Sequence, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import MM_PER_M, description_of
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.records import Focus, Traces, longer_m
from gpr20_analysis.processing.antenna_step import ENDS, SURFACE_PERMITTIVITY, WIDEST_RATIO
from gpr20_analysis.processing.sweep import steps_to_top
from gpr20_analysis.work import no_progress
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_survey.folder.log_record import ENTERED, OF_PLAN, soil_of_survey
from gpr20_survey.radar import ANY_SOIL, MAX_PERMITTIVITY, Soil, one_way_path_m, soil_of

if TYPE_CHECKING:
    from gpr20_analysis.imaging.image_options import ImageOptions, Method


GIVEN_UNCERTAINTY = 0.1
"""What a value that a person gave may be off, as a share of it: a good probe, at another place."""


class Source(enum.Enum):
    """Where a permittivity is from, the most reliable first; the value is for files."""

    SURFACE = "measured at the surface"
    BURIED = "measured with a buried reference"
    GIVEN = "given"
    SOIL = "typical of the soil"
    PLAN = OF_PLAN
    ENTERED = ENTERED
    ASSUMED = "assumed"

    @property
    def message(self) -> Message:
        """For people."""
        return _MESSAGES[self]


_MESSAGES = {
    Source.SURFACE: Message("MEASURED at the surface against a metal plate"),
    Source.BURIED: Message("MEASURED with the buried reference"),
    Source.GIVEN: Message("as given"),
    Source.SOIL: Message("TYPICAL of the chosen soil, not measured"),
    Source.PLAN: Message("of the plan of the survey"),
    Source.ENTERED: Message("entered later, in the log of the survey"),
    Source.ASSUMED: Message("ASSUMED, as nothing is known of the ground"),
}


@dataclass(frozen=True)
class KnownPermittivity:
    """A permittivity and how well it is known.

    Attributes:
        permittivity: Best value.
        lowest: Lowest likely value (95 % range).
        highest: Highest likely value.
        source: Where it is from.
    """

    permittivity: float
    lowest: float
    highest: float
    source: Source

    @classmethod
    def of_soil(cls, soil: Soil, source: Source) -> KnownPermittivity:
        """Return the usual permittivity of a soil."""
        return cls(soil.permittivity, soil.lowest, soil.highest, source)

    @classmethod
    def within(cls, permittivity: float, share: float, source: Source) -> KnownPermittivity:
        """Return a value that may be off by a share of it."""
        lowest = max(permittivity * (1.0 - share), 1.0)
        return cls(permittivity, lowest, permittivity * (1.0 + share), source)

    def attributes(self) -> Dict[str, object]:
        """Return the attributes of an image."""
        return {
            "permittivity_source": self.source.value,
            "permittivity_lowest": self.lowest,
            "permittivity_highest": self.highest,
            "depth_uncertainty": depth_shares(self.permittivity, self.lowest, self.highest)[0],
        }


def depth_shares(permittivity: float, lowest: float, highest: float) -> Tuple[float, float, float]:
    """Return by what share depths are uncertain at most, may be too small, and too large."""
    deeper = float(np.sqrt(permittivity / lowest)) - 1.0
    shallower = 1.0 - float(np.sqrt(permittivity / highest))
    return max(deeper, shallower), deeper, shallower


def permittivity_line(image: xr.Dataset) -> Message:
    """Return the permittivity of an image, where it is from, and the uncertainty of depths.

    Args:
        image: Dataset with `image`.
    """
    value = float(image.attrs["permittivity"])
    lowest, highest = permittivity_range(image)
    _, deeper, shallower = depth_shares(value, lowest, highest)
    return Message(
        "The soil's permittivity is {permittivity:.3g}, {source}; {lowest:.3g} to {highest:.3g} is "
        "likely, so depths may be wrong by {shallower:+.0f} % to {deeper:+.0f} %.",
        permittivity=value,
        source=Source(image.attrs.get("permittivity_source", Source.GIVEN.value)).message,
        lowest=lowest,
        highest=highest,
        shallower=-100.0 * shallower,
        deeper=100.0 * deeper,
    )


def permittivity_range(image: xr.Dataset) -> Tuple[float, float]:
    """Return the lowest and highest likely permittivity of an image, also of other programs."""
    value = float(image.attrs["permittivity"])
    lowest = float(image.attrs.get("permittivity_lowest", value * (1.0 - GIVEN_UNCERTAINTY)))
    highest = float(image.attrs.get("permittivity_highest", value * (1.0 + GIVEN_UNCERTAINTY)))
    return max(lowest, 1.0), highest


# How far the object may be from the place that was given.
AWAY_M = 0.042
OPTICAL_STEP_M = 0.003
# Of depth and height as people and sensors measure them; twice that is the 95 % range.
DEPTH_DEVIATION_M, HEIGHT_DEVIATION_M = 0.003, 0.003
# Of the resolution in air: how well the delay of an echo is known.
OF_RESOLUTION = 0.2
# Of the median over all depths, and of the strongest echo.
CLEAR, STRONG = 4.0, 0.5
# Of the median of the strongest echoes at places beside it.
STANDS_OUT, BESIDE_M, FEWEST_BESIDE = 3.0, 0.12, 3
TRIAL_PERMITTIVITY = 5.0
NOTHING = 0.0, 1e-3


@dataclass(frozen=True)
class BuriedReference:
    """An object of metal that was buried on purpose.

    Attributes:
        x_m: Its middle along X [m].
        y_m: Its middle along Y [m].
        depth_m: Depth of its top below the surface [m].
    """

    x_m: float
    y_m: float
    depth_m: float


def permittivity_of(
    survey: xr.Dataset, traces: Sequence[Traces], focus: Focus, options: ImageOptions
) -> Tuple[KnownPermittivity, List[Message]]:
    """Return the permittivity of an image, how it is known, and notes on what contradicts it.

    Args:
        survey: The survey; after the step `antenna` its surface gives a permittivity, else its
            plan or its log may.
        traces: Its traces, one item per polarization.
        focus: How the image is focused.
        options: What a person gave; without anything, and without that of surface and survey,
            any soil is assumed.

    Raises:
        WrongDatasetError: The buried reference does not give it.
    """
    measured = None
    if SURFACE_PERMITTIVITY in survey.attrs:
        lowest, best, highest = (float(survey.attrs[SURFACE_PERMITTIVITY + end]) for end in ENDS)
        measured = KnownPermittivity(best, lowest, highest, Source.SURFACE)
    share = options.permittivity_uncertainty
    noted = soil_of_survey(description_of(survey))
    if options.permittivity is not None:
        known = KnownPermittivity.within(options.permittivity, share, Source.GIVEN)
    elif options.soil is not None:
        known = KnownPermittivity.of_soil(options.soil.value, Source.SOIL)
    elif options.buried is not None:
        known = permittivity_of_reference(traces, focus, options.buried, options.method)
    elif measured is not None:
        known = measured
    elif noted is None:
        known = KnownPermittivity.of_soil(ANY_SOIL, Source.ASSUMED)
    else:
        soil, source = soil_of(noted.permittivity), Source(noted.source)
        if soil is not None:
            known = KnownPermittivity.of_soil(soil.value, source)
        else:
            known = KnownPermittivity.within(noted.permittivity, share, source)
    if measured is None or (known.lowest <= measured.highest and measured.lowest <= known.highest):
        return known, []
    contradiction = Message(
        "the surface reflects like soil of permittivity {lowest:.3g} to {highest:.3g}, but the "
        "image is made with {used:.3g}",
        lowest=measured.lowest,
        highest=measured.highest,
        used=known.permittivity,
    )
    return known, [contradiction]


def permittivity_of_reference(
    traces: Sequence[Traces], focus: Focus, reference: BuriedReference, method: Method
) -> KnownPermittivity:
    """Return the permittivity that puts the echo of the reference at its depth.

    Args:
        traces: One item per polarization, without coupling and surface echo.
        focus: How to focus; its depths and permittivity are not used.
        reference: The object.
        method: Makes the images in which its echo is looked for.

    Raises:
        WrongDatasetError: No trace is near it, or no clear echo of it.
    """
    level, optical_m = max(_echo(one, focus, reference, method) for one in traces)
    band_hz = traces[0].sweep.step_hz * traces[0].sweep.count
    of_echo_m = float(np.hypot(OF_RESOLUTION * one_way_path_m(1.0 / band_hz), HEIGHT_DEVIATION_M))
    # The surface above it may be as much higher or lower as the heights differ.
    relief_m = max(float(np.std(one.height_m)) for one in traces)
    of_depth_m = float(np.hypot(DEPTH_DEVIATION_M, relief_m))
    # Of the square of a quotient: twice its share; the range is two deviations.
    share = np.hypot(of_echo_m / optical_m, of_depth_m / reference.depth_m)
    ratio = math.exp(4.0 * min(float(share), 1.0))
    permittivity = (optical_m / reference.depth_m) ** 2
    lowest, highest = max(permittivity / ratio, 1.0), permittivity * ratio
    if not (level >= CLEAR and permittivity > 1.0 and highest <= WIDEST_RATIO * lowest):
        raise WrongDatasetError(
            Message(
                "the buried reference at x {x_mm:.0f} mm, y {y_mm:.0f} mm gives no permittivity: "
                "not one clear echo is below that place, or it is too shallow for the band and the "
                "heights; check its place, or give the permittivity",
                x_mm=MM_PER_M * reference.x_m,
                y_mm=MM_PER_M * reference.y_m,
            ),
            fault=NOT_ALLOWED,
        )
    return KnownPermittivity(permittivity, lowest, highest, Source.BURIED)


def _echo(
    traces: Traces, focus: Focus, reference: BuriedReference, method: Method
) -> Tuple[float, float]:
    """Return how far the strongest echo is above the others, and its depth times the index [m].

    No level if it is not the only strong one below that place, or not stronger than elsewhere.
    """
    away_m = np.hypot(traces.x_m - reference.x_m, traces.y_m[:, None] - reference.y_m)
    near, beside = away_m <= AWAY_M, away_m > BESIDE_M
    if not near.any() or np.count_nonzero(beside) < FEWEST_BESIDE:
        return NOTHING
    height_m = float(traces.height_m.max())
    unambiguous_m = one_way_path_m(traces.sweep.unambiguous_s) - height_m
    deepest_m = min(reference.depth_m * math.sqrt(MAX_PERMITTIVITY), unambiguous_m / 2.0)
    optical_m = np.arange(0.8 * reference.depth_m, deepest_m, OPTICAL_STEP_M)
    depth_m = optical_m / math.sqrt(TRIAL_PERMITTIVITY)
    trial = replace(focus, permittivity=TRIAL_PERMITTIVITY, depth_m=depth_m)
    magnitude = np.abs(method.image(traces, trial, no_progress))
    level = magnitude[:, near].max(axis=1)
    # Residue of the surface or another body may be as strong: then they cannot be distinguished.
    inner = level[1:-1]
    tops = (inner > level[:-2]) & (inner >= level[2:]) & (inner >= STRONG * level.max())
    at = 1 + int(np.argmax(tops))
    # Where nothing was buried some echo is the strongest, too, but no stronger than elsewhere.
    around = np.median(magnitude[:, beside].max(axis=0))
    if np.count_nonzero(tops) != 1 or level[at] < STANDS_OUT * around:
        return NOTHING
    beyond = float(steps_to_top(level[None], np.array([at]))[0])
    found_m = float(optical_m[at] + beyond * OPTICAL_STEP_M)
    if not method.exact_paths:
        # The way between antennas that are apart is longer.
        found_m -= longer_m(height_m + found_m, focus.separation_m)
    return float(level[at] / np.median(level)), found_m
