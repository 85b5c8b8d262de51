"""The figures of a survey in words."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, List, Optional, Tuple

from gpr20_common.message import Message, verbatim
from gpr20_operator.plan.parameter_form import HERTZ_PER_MEGAHERTZ
from gpr20_operator.plan.spacing import ROUNDING
from gpr20_operator.robot.events import RobotFigures
from gpr20_operator.words import duration
from gpr20_survey.plan.survey_cost import SurveyCost, survey_cost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.radar.depth import one_way_path_m, quarter_wavelength_m


@dataclass(frozen=True)
class SurveyPreview:
    """Figures of a survey.

    Attributes:
        stops: Number of places.
        traces: Number of traces, one per stop and polarization.
        x_spacing_mm: Distance of two stops of a line [mm].
        y_spacing_mm: Distance of two lines [mm].
        frequency_step_hz: Distance of two frequencies [Hz].
        depth_m: Depth in the soil beyond which echoes fold back [m].
        resolution_m: Smallest distance of two separate echoes in the soil [m].
        quarter_wavelength_mm: Coarsest spacing that samples the echoes completely [mm].
        cost: Time and disk space; None while the robot's own figures are not known.
    """

    stops: int
    traces: int
    x_spacing_mm: float
    y_spacing_mm: float
    frequency_step_hz: float
    depth_m: float
    resolution_m: float
    quarter_wavelength_mm: float
    cost: Optional[SurveyCost] = None

    @property
    def too_coarse(self) -> bool:
        """Whether stops are farther apart than a quarter wavelength."""
        widest_mm = max(self.x_spacing_mm, self.y_spacing_mm)
        return widest_mm > self.quarter_wavelength_mm * (1.0 + ROUNDING)


def quarter_wavelength_mm(parameters: SurveyParameters, permittivity: float) -> float:
    """Return the coarsest spacing that samples the echoes of the ground completely [mm].

    Args:
        parameters: Their centre frequency counts.
        permittivity: Relative permittivity of the ground.
    """
    centre_hz = (parameters.start_frequency_hz + parameters.stop_frequency_hz) / 2.0
    return 1000.0 * quarter_wavelength_m(centre_hz, permittivity)


def preview(parameters: SurveyParameters, permittivity: float) -> SurveyPreview:
    """Return what follows from the parameters alone; they must have passed the checks.

    A stepped-frequency radar ranges unambiguously to c / (2 df) and resolves echoes by c / (2 B)
    in air. In soil both are shorter by the square root of its relative permittivity.

    Args:
        parameters: What to measure.
        permittivity: Relative permittivity of the soil.
    """
    p = parameters
    bandwidth_hz = p.stop_frequency_hz - p.start_frequency_hz
    step_hz = bandwidth_hz / (p.frequency_points - 1)
    return SurveyPreview(
        stops=p.x_points * p.y_points,
        traces=p.total_points,
        x_spacing_mm=abs(p.x_stop_mm - p.x_start_mm) / (p.x_points - 1),
        y_spacing_mm=abs(p.y_stop_mm - p.y_start_mm) / (p.y_points - 1),
        frequency_step_hz=step_hz,
        depth_m=one_way_path_m(1.0 / step_hz, permittivity),
        resolution_m=one_way_path_m(1.0 / bandwidth_hz, permittivity),
        quarter_wavelength_mm=quarter_wavelength_mm(parameters, permittivity),
    )


@dataclass(frozen=True)
class CostEstimated:
    """Time and disk space of a survey with given parameters."""

    parameters: SurveyParameters
    cost: SurveyCost


class CostEstimator:
    """Estimates beside the window's thread: a large survey takes seconds.

    Only the newest request counts.

    Args:
        listener: Called with each CostEstimated, from a thread of this class.
    """

    def __init__(self, listener: Callable[[CostEstimated], None]) -> None:
        self._listener = listener
        self._lock = threading.Lock()
        self._wanted: Optional[Tuple[SurveyParameters, RobotFigures]] = None
        self._working = False
        self._closed = False

    def close(self) -> None:
        """Call the listener no more, even if an estimate is in progress."""
        with self._lock:
            self._closed = True

    def ask(self, parameters: SurveyParameters, figures: RobotFigures) -> None:
        """Estimate; the listener gets the result."""
        with self._lock:
            self._wanted = parameters, figures
            if self._working:
                return
            self._working = True
        threading.Thread(target=self._work, name="cost_estimator", daemon=True).start()

    def _work(self) -> None:
        while True:
            with self._lock:
                if self._wanted is None or self._closed:
                    self._working = False
                    return
                (parameters, figures), self._wanted = self._wanted, None
            cost = survey_cost(parameters, figures.config, figures.settings)
            with self._lock:
                # The listener may be gone once this has been closed.
                if not self._closed:
                    self._listener(CostEstimated(parameters, cost))


UNKNOWN = verbatim("—")
BYTES_PER_MEGABYTE = 1.0e6
MILLIMETRES_PER_METRE = 1000.0
SPACING = Message("Spacing X, Y")
TITLES = (
    Message("Traces"),
    Message("Stops"),
    Message("Estimated time"),
    Message("Disk space"),
    SPACING,
    Message("λ/4 in soil"),
    Message("Depth in soil"),
    Message("Resolution in soil"),
    Message("Frequency step"),
    Message("Traces per stop"),
)


def figure_texts(preview: Optional[SurveyPreview]) -> List[Tuple[Message, Message]]:
    """Return title and text of each figure.

    Args:
        preview: Of the survey; None while its parameters are wrong.
    """
    texts = (UNKNOWN,) * len(TITLES) if preview is None else _texts(preview)
    return list(zip(TITLES, texts))


def spacing_warning(preview: Optional[SurveyPreview]) -> Optional[Message]:
    """Return the warning that the stops are too far apart for the soil; None if they are not."""
    if preview is None or not preview.too_coarse:
        return None
    return Message(
        "Spacing {spacing:.4g} mm is more than λ/4 = {quarter:.3g} mm in this soil: the image may "
        "miss or double targets",
        spacing=max(preview.x_spacing_mm, preview.y_spacing_mm),
        quarter=preview.quarter_wavelength_mm,
    )


def short_warning(preview: Optional[SurveyPreview]) -> Optional[Message]:
    """Return the same warning in a few words."""
    if preview is None or not preview.too_coarse:
        return None
    return Message(
        "Spacing {spacing:.4g} mm > λ/4 {quarter:.3g} mm",
        spacing=max(preview.x_spacing_mm, preview.y_spacing_mm),
        quarter=preview.quarter_wavelength_mm,
    )


def short_figures(preview: Optional[SurveyPreview]) -> Tuple[Message, Message]:
    """Return the most important figures in two lines."""
    if preview is None:
        return UNKNOWN, verbatim("")
    cost = preview.cost
    size = Message("{traces} traces", traces=preview.traces)
    if cost is not None:
        size = Message(
            "{traces} traces, {time}", traces=preview.traces, time=duration(cost.duration_s)
        )
    depth = Message(
        "Depth {depth:.3g} m, resolution {resolution:.3g} mm",
        depth=preview.depth_m,
        resolution=preview.resolution_m * MILLIMETRES_PER_METRE,
    )
    return size, depth


def _texts(preview: SurveyPreview) -> Tuple[Message, ...]:
    cost = preview.cost
    return (
        verbatim(f"{preview.traces}"),
        verbatim(f"{preview.stops}"),
        UNKNOWN if cost is None else duration(cost.duration_s),
        UNKNOWN if cost is None else verbatim(f"{cost.size_bytes / BYTES_PER_MEGABYTE:.4g} MB"),
        verbatim(f"{preview.x_spacing_mm:.4g}, {preview.y_spacing_mm:.4g} mm"),
        verbatim(f"{preview.quarter_wavelength_mm:.3g} mm"),
        verbatim(f"{preview.depth_m:.3g} m"),
        verbatim(f"{preview.resolution_m * MILLIMETRES_PER_METRE:.3g} mm"),
        verbatim(f"{preview.frequency_step_hz / HERTZ_PER_MEGAHERTZ:.4g} MHz"),
        verbatim(f"{preview.traces // preview.stops}"),
    )
