"""Images with the echoes that a test wants, in clutter."""

import numpy as np
import xarray as xr

from gpr20_analysis.candidates.answer import answer
from gpr20_analysis.candidates.search import find_candidates
from gpr20_analysis.dataset import CLUTTER, DEPTH, ECHOES, IMAGE, POLARIZATION, X, Y
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.records import Ground

STEP_M = 0.01
SHAPE = (31, 61, 61)
RESOLUTION_M = 0.03
CLUTTER_DB = -20.0


def weak_echoes(random, count, rotations):
    """Return echoes of clutter: maxima that fall off by a factor of 10 in 3.5 dB."""
    place_m = random.uniform(0.0, 1.0, (count, 3)) * (STEP_M * (np.array(SHAPE) - 1))
    above_db = 2.0 + random.exponential(1.5, count)
    turns = random.choice(rotations, count)
    return np.column_stack([turns, place_m, above_db, above_db + CLUTTER_DB, np.zeros(count)])


def image_of(peaks, seed=0, rotations=(0.0, 90.0), weak=400, **attributes):
    """Return an image with peaks (polarization, x, y, depth [m], above clutter [dB])."""
    axes = [STEP_M * np.arange(count) for count in SHAPE]
    strong = [
        (rotations[turn], depth_m, y_m, x_m, above_db, above_db + CLUTTER_DB, 1.0)
        for turn, x_m, y_m, depth_m, above_db in peaks
    ]
    random = np.random.default_rng(seed)
    rows = np.concatenate([np.array(strong).reshape(-1, 7), weak_echoes(random, weak, rotations)])
    return xr.Dataset(
        {
            IMAGE: ((POLARIZATION, DEPTH, Y, X), np.ones((len(rotations), *SHAPE), np.complex64)),
            CLUTTER: ((POLARIZATION, DEPTH), np.ones((len(rotations), SHAPE[0]))),
            ECHOES: (("echo", "value"), rows),
        },
        {POLARIZATION: list(rotations), DEPTH: axes[0], Y: axes[1], X: axes[2]},
        {
            "method": "phase-shift",
            "permittivity": 4.0,
            "notes": [],
            "depth_resolution_m": RESOLUTION_M,
            **attributes,
        },
    )


def by_default(survey, permittivity=5.0):
    """Return the image that the command makes of level ground without options."""
    return answer(survey, ImageOptions(permittivity=permittivity, ground=Ground.LEVEL)).image


def places(image, rate=10.0):
    """Return the places to check in an image."""
    return find_candidates(image, rate).shown()
