"""How an image is made: the method, also one of an installed package, and the values it needs."""

from __future__ import annotations

import numbers
from dataclasses import dataclass
from typing import Callable, ClassVar, Optional, Tuple

import numpy as np

from gpr20_analysis import errors
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.imaging.back_projection import back_projection_image
from gpr20_analysis.imaging.permittivity import GIVEN_UNCERTAINTY, BuriedReference
from gpr20_analysis.imaging.phase_shift import phase_shift_image
from gpr20_analysis.imaging.records import Focus, Ground, Traces
from gpr20_analysis.work import Progress
from gpr20_common.errors import InvalidValueError
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message, numeral
from gpr20_common.mid.checks import Text, number_between
from gpr20_survey.plan.annotation import FALSE_ALARMS_PER_M2
from gpr20_survey.radar import LARGEST_PERMITTIVITY, MIN_PERMITTIVITY, Soils

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
    fault=errors.STEPS,
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


@dataclass(frozen=True)
class ImageOptions:
    """The options of an image.

    Attributes:
        method: How the image is computed.
        permittivity: Relative permittivity of the soil that a person gave.
        depth_m: Depths [m], ascending.
        height_m: One antenna height for all traces instead of the recorded ones [m].
        leave_out_missing: Make the image without the missing samples, instead of refusing.
        separation_m: Distance between the antennas [m]; used by back-projection and with a
            buried reference. 0: the one that the survey records, else none.
        ground: Why the recorded heights differ; back-projection alone knows uneven ground. None:
            level, but the other methods refuse heights that differ much.
        delay_s: Delay of cables and antennas to remove [s]; None: the one that the survey
            records, else none.
        permittivity_uncertainty: What the given permittivity may be off, as a share of it.
        soil: Kind of soil that a person chose.
        buried: A reference that was buried at a known depth. Of permittivity, soil and reference
            one may be given. Without any, the reflection of the surface gives the permittivity of
            data after the step `antenna`, else the plan or the log of the survey.
        false_alarms_per_m2: Where the list of candidates is cut [1/m2]; None: as the survey's site
            has set it, else the usual rate.
    """

    method: Method = Method.PHASE_SHIFT
    permittivity: Optional[float] = None
    depth_m: Tuple[float, ...] = tuple(np.round(np.arange(0.0, 0.3001, 0.003), 6))
    height_m: Optional[float] = None
    leave_out_missing: bool = False
    separation_m: float = 0.0
    ground: Optional[Ground] = None
    delay_s: Optional[float] = None
    permittivity_uncertainty: float = GIVEN_UNCERTAINTY
    soil: Optional[Soils] = None
    buried: Optional[BuriedReference] = None
    false_alarms_per_m2: Optional[float] = None

    def __post_init__(self) -> None:
        """Check the options.

        Raises:
            WrongDatasetError: A value is not allowed.
        """
        depth_m = np.asarray(self.depth_m, dtype=np.float64)
        if depth_m.size < 2 or not np.all(np.diff(depth_m) > 0.0) or not depth_m[0] >= 0.0:
            raise WrongDatasetError(
                Message(
                    "the depths are {depths} m; they must be two or more, ascending, not negative",
                    depths=tuple(map(numeral, depth_m[:5])) or "-",
                ),
                fault=NOT_ALLOWED,
            )
        permittivity = Message("the permittivity")
        check_range(permittivity, self.permittivity, MIN_PERMITTIVITY, LARGEST_PERMITTIVITY)
        share = Message("the uncertainty of the permittivity")
        check_range(share, self.permittivity_uncertainty, 0.01, 0.9)
        if [self.permittivity, self.soil, self.buried].count(None) < 2:
            raise WrongDatasetError(
                Message(
                    "the permittivity is given more than once; use one of --permittivity, --soil "
                    "and --buried"
                ),
                fault=NOT_ALLOWED,
            )
        if self.buried is not None:
            name = Message("the depth of the buried reference")
            check_range(name, self.buried.depth_m, 0.02, 1.0, "m")
        check_range(Message("the antenna height"), self.height_m, 0.001, 10.0, "m")
        check_range(Message("the antenna separation"), self.separation_m, 0.0, 2.0, "m")
        rate = Message("the rate of false alarms per m2")
        check_range(rate, self.false_alarms_per_m2, *FALSE_ALARMS_PER_M2)
        # As the command line gives them.
        delay_ns = None if self.delay_s is None else 1e9 * self.delay_s
        check_range(Message("the delay of cables and antennas"), delay_ns, -1e4, 1e4, "ns")
        if self.ground is Ground.UNEVEN and not self.method.exact_paths:
            raise WrongDatasetError(
                Message(
                    "the method {method} has no {option}; that needs --method {other}",
                    method=self.method.name,
                    option="--ground uneven",
                    other=Method.BACK_PROJECTION.name,
                ),
                fault=NOT_ALLOWED,
            )


def check_range(
    name: Text, value: Optional[float], lowest: float, highest: float, unit: Text = ""
) -> None:
    """Check a number that a person gave, unless it is None.

    Raises:
        WrongDatasetError: It is no number, NaN or outside the range.
    """
    if value is None:
        return
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise WrongDatasetError(
            Message("{name} is {value}; it must be a number", name=name, value=repr(value)),
            fault=NOT_ALLOWED,
        )
    try:
        number_between(name, value, lowest, highest, unit)
    except InvalidValueError as error:
        raise WrongDatasetError(error.message, fault=NOT_ALLOWED) from error
