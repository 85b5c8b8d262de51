"""The figures of a survey that is planned."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, Optional, Tuple

from gpr20_operator.files.newest import Newest
from gpr20_operator.plan.form import ROUNDING
from gpr20_operator.robot.events import Configured
from gpr20_survey.plan.survey_cost import SurveyCost, survey_cost
from gpr20_survey.plan.survey_parameters import SurveyParameters
from gpr20_survey.radar.depth import one_way_path_m


@dataclass(frozen=True)
class SurveyPreview:
    """Figures of a survey.

    Attributes:
        stops: Number of places.
        traces: Number of traces, one per stop and polarization.
        x_spacing_mm: Distance of two stops of a line [mm].
        y_spacing_mm: Distance of two lines [mm].
        depth_m: Depth in the soil beyond which echoes fold back [m].
        resolution_m: Smallest distance of two separate echoes in the soil [m].
        quarter_wavelength_mm: Coarsest spacing that samples the echoes completely [mm].
        cost: Time and disk space; None while the robot's own figures are not known.
    """

    stops: int
    traces: int
    x_spacing_mm: float
    y_spacing_mm: float
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

    Grasmueck, Weger and Horstmeyer, "Full-resolution 3D GPR imaging", Geophysics 70 (2005), K12 to
    K19.
    """
    centre_hz = (parameters.start_frequency_hz + parameters.stop_frequency_hz) / 2.0
    return 1000.0 * one_way_path_m(1.0 / centre_hz, permittivity) / 2.0


def preview(parameters: SurveyParameters, permittivity: float) -> SurveyPreview:
    """Return what follows from the parameters alone; they must have passed the checks.

    A stepped-frequency radar ranges unambiguously to c / (2 df) and resolves echoes by c / (2 B)
    in air. In soil both are shorter by the square root of its relative permittivity.
    """
    p = parameters
    bandwidth_hz = p.stop_frequency_hz - p.start_frequency_hz
    step_hz = bandwidth_hz / (p.frequency_points - 1)
    return SurveyPreview(
        stops=p.x_points * p.y_points,
        traces=p.total_points,
        x_spacing_mm=abs(p.x_stop_mm - p.x_start_mm) / (p.x_points - 1),
        y_spacing_mm=abs(p.y_stop_mm - p.y_start_mm) / (p.y_points - 1),
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
    """Estimates beside the window's thread: a large survey takes seconds. The newest counts."""

    def __init__(self, listener: Callable[[CostEstimated], None]) -> None:
        self._listener = listener
        self._newest = Newest(self._estimate)
        self._lock = threading.Lock()
        self._closed = False

    def close(self) -> None:
        """Call the listener no more, even if an estimate is in progress."""
        with self._lock:
            self._closed = True

    def ask(self, parameters: SurveyParameters, robot: Configured) -> None:
        """Estimate; the listener gets the result."""
        self._newest.put((parameters, robot))

    def _estimate(self, asked: Tuple[SurveyParameters, Configured]) -> None:
        parameters, robot = asked
        if self._closed:
            return
        cost = survey_cost(parameters, robot.config, robot.settings)
        with self._lock:
            # The listener may be gone once this has been closed.
            if not self._closed:
                self._listener(CostEstimated(parameters, cost))
