"""The imaging methods: those of this package, and those of installed packages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, ClassVar

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


@dataclass(frozen=True)
class Method:
    """How an image is computed; that of a sum of traces is the sum of their images.

    Attributes:
        name: Its name, which images record.
        image: Makes the image (depth, y, x) of one polarization, complex.
        exact_paths: It knows the separation of the antennas, and uneven ground.
    """

    name: str
    image: Callable[[Traces, Focus, Progress], np.ndarray]
    exact_paths: bool = False

    PHASE_SHIFT: ClassVar[Method]
    BACK_PROJECTION: ClassVar[Method]


Method.PHASE_SHIFT = Method("phase-shift", phase_shift_image)
Method.BACK_PROJECTION = Method("back-projection", back_projection_image, exact_paths=True)

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
