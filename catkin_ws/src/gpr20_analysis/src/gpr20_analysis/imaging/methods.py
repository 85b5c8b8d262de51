"""The imaging methods: those of this package, and those of installed packages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, ClassVar, Optional, Tuple

import numpy as np

from gpr20_analysis import faults
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.imaging.back_projection import back_projection_image
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Traces
from gpr20_analysis.work import Progress
from gpr20_common.message import Message

DEFAULT_STEPS = ("background:method=surface",)
"""Steps before an image of a survey without steps."""
Positions = Tuple[Optional[np.ndarray], Optional[np.ndarray]]
"""Positions of the image along X and Y [m]; None: those of the traces."""
Volume = Tuple[np.ndarray, np.ndarray]
"""Image (depth, y, x) of one polarization and its depths [m]."""


@dataclass(frozen=True)
class Method:
    """How an image is computed.

    Attributes:
        name: Its name, which images record.
        image: Makes the image of one polarization.
        is_linear: The image of a sum of traces is the sum of their images, and complex.
        factors: Amplitudes that a voxel multiplies: its magnitude is a power of that order.
        exact_paths: It knows the separation of the antennas, and uneven ground.
        any_positions: It can image at other positions than those of the survey.
        default_steps: Steps before an image of a survey without steps.
    """

    name: str
    image: Callable[[Traces, Focus, Positions, Progress], Volume]
    is_linear: bool = True
    factors: int = 1
    exact_paths: bool = False
    any_positions: bool = True
    default_steps: Tuple[str, ...] = DEFAULT_STEPS

    PHASE_SHIFT: ClassVar[Method]
    BACK_PROJECTION: ClassVar[Method]


def _phase_shift(traces: Traces, focus: Focus, at: Positions, progress: Progress) -> Volume:
    return phase_shift_image(traces, focus, *at), focus.depth_m


def _back_projection(traces: Traces, focus: Focus, at: Positions, progress: Progress) -> Volume:
    return back_projection_image(traces, focus, *at, progress=progress), focus.depth_m


Method.PHASE_SHIFT = Method("phase-shift", _phase_shift)
Method.BACK_PROJECTION = Method("back-projection", _back_projection, exact_paths=True)

METHODS = ExtensionPoint(
    "gpr20_analysis.imaging_methods",
    Message("the method"),
    fault=faults.STEPS,
    own={one.name: one for one in (Method.PHASE_SHIFT, Method.BACK_PROJECTION)},
    kind=Method,
)
"""By this, other packages add imaging methods."""


def imaging_method(name: str) -> Method:
    """Return an imaging method.

    Args:
        name: Its name; also that of a method of another installed package.

    Raises:
        MissingLibraryError: Its package is not installed.
        AnalysisError: There is none, or its package cannot be used.
    """
    found: Method = METHODS.find(name)
    return found
