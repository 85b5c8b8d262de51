"""The echo of the surface compared with the recorded heights, for the notes of an image."""

from __future__ import annotations

from typing import List

import numpy as np
import xarray as xr

from gpr20_analysis.dataset import HEIGHT, MM_PER_M, usable
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.processing.antenna_delay import REMOVED
from gpr20_analysis.processing.surface_echo import SURFACE_DELAY
from gpr20_common.message import Message
from gpr20_survey.radar.depth import one_way_path_m

NOTED_M = 0.005
"""Median difference of surface echo and height above which an image has a note [m]."""


def surface_notes(survey: xr.Dataset, options: ImageOptions, delay_s: float) -> List[Message]:
    """Return a note if the surface is not where the image assumes it.

    Args:
        survey: The survey; without attribute `surface_delay_s` its surface echo was not clear.
        options: The options of the image.
        delay_s: Delay of cables and antennas that the image removes [s].
    """
    if SURFACE_DELAY not in survey.attrs:
        return []
    recorded_m = float(survey[HEIGHT].where(usable(survey)).median())
    used_m = recorded_m if options.height_m is None else options.height_m
    removed_s = delay_s + float(survey.attrs.get(REMOVED, 0.0))
    echo_m = recorded_m + one_way_path_m(float(survey.attrs[SURFACE_DELAY]) - removed_s)
    expected_m = float(np.hypot(used_m, 0.5 * options.separation_m))
    difference_m = echo_m - expected_m
    # Written so that a height that is not known gives no note.
    if not abs(difference_m) > NOTED_M:
        return []
    return [
        Message(
            "the surface echo is {difference_mm:+.0f} mm from the antenna height (median of the "
            "traces; limit {limit_mm:.0f} mm), so all depths are wrong; find the delay of cables "
            "and antennas with gpr20 delay, and check the height sensor",
            difference_mm=MM_PER_M * difference_m,
            limit_mm=MM_PER_M * NOTED_M,
        )
    ]
