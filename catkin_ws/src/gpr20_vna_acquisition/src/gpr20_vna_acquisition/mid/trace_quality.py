"""What a trace shows about itself: remarks that travel with it, and what is no measurement.

A remark never costs a trace: it tells a technician what to look at, and an analyst what to
doubt. Only numbers that no measurement can give are refused.
"""

from __future__ import annotations

import statistics
from collections import deque
from typing import Deque, Optional, Sequence, Tuple

import numpy as np

from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep, storable_remark
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# A duration is unusual beyond this factor from the usual one.
DURATION_FACTOR = 2.0
# On a quick sweep polling and the computer decide how long it seems to take [s].
EARLY_TOLERANCE_S = 0.05
# So many sweeps must have been made before one can be unusual, and so many are remembered.
FEWEST_SWEEPS, MOST_SWEEPS = 5, 25
# So many reasons of repetitions are told of one sweep, one remark each.
MOST_REASONS = 8

CALIBRATION_REMARKS = {
    CalibrationStatus.NONE: "the VNA is not calibrated; calibrate it before going on",
    CalibrationStatus.MODERATE_POWER: "the calibration is moderate: its power level was another",
    CalibrationStatus.MODERATE_TEMPERATURE: (
        "the calibration is moderate: the VNA is more than 5 degrees warmer or colder than then"
    ),
    CalibrationStatus.LOW: (
        "the calibration is low: the VNA is more than 10 degrees warmer or colder than then; "
        "calibrate it again"
    ),
}


def refuse_impossible(sweep: Sweep) -> None:
    """Do nothing with data that a measurement can have given.

    Raises:
        VnaDataError: Every number is zero, or the imaginary part is a copy of the real one.
    """
    if not (sweep.s21_real.any() or sweep.s21_imag.any()):
        raise VnaDataError("every number of the trace is zero; nothing was measured")
    if (sweep.s21_real == sweep.s21_imag).all():
        raise VnaDataError("the imaginary part of the trace is a copy of its real part")


def calibration_refusal(status: CalibrationStatus, parameters: VnaParameters) -> str:
    """Say why no survey may be made with this calibration; empty if one may."""
    if status in parameters.accepted_calibrations:
        return ""
    listed = ", ".join(str(int(one)) for one in parameters.accepted_calibrations)
    return (
        f"the VNA's calibration status is {int(status)} ({status.meaning}); calibrate it, or "
        f"change accepted_calibrations (now {listed})"
    )


def level_remarks(sweep: Sweep, parameters: VnaParameters) -> Tuple[str, ...]:
    """Return remarks on the magnitude of S21."""
    with np.errstate(divide="ignore"):
        levels_db = 20.0 * np.log10(np.hypot(sweep.s21_real, sweep.s21_imag))
    median_db, largest_db = float(np.median(levels_db)), float(levels_db.max())
    remarks = []
    if median_db < parameters.min_level_db:
        remarks.append(
            f"S21 is weak: {median_db:.1f} dB in the middle, expected are "
            f"{parameters.min_level_db:g} dB or more; check that both antennas are connected"
        )
    if largest_db > parameters.max_level_db:
        remarks.append(
            f"S21 is strong: up to {largest_db:.1f} dB, expected are "
            f"{parameters.max_level_db:g} dB at most; the receiver may be overloaded or the "
            "calibration be another setup's"
        )
    return tuple(remarks)


def flat_remarks(sweep: Sweep, parameters: VnaParameters) -> Tuple[str, ...]:
    """Return a remark if points in a row are equal to the last bit; noise never is."""
    changes = (np.diff(sweep.s21_real) != 0.0) | (np.diff(sweep.s21_imag) != 0.0)
    edges = np.concatenate(([-1], np.flatnonzero(changes), [len(changes)]))
    longest = int(np.diff(edges).max())
    if longest < parameters.same_points:
        return ()
    return (
        f"{longest} of {len(sweep.s21_real)} points in a row are the very same number; "
        "check that the VNA sweeps and is not in zero span",
    )


def duration_remarks(
    duration_s: float, usual_s: Optional[float], parameters: VnaParameters
) -> Tuple[str, ...]:
    """Return a remark if a sweep took much longer or shorter than usual.

    Args:
        duration_s: How long it took [s].
        usual_s: How long it usually takes [s], if that is known.
        parameters: How late is remarkable.
    """
    if usual_s is None:
        return ()
    earliest_s = usual_s / DURATION_FACTOR - EARLY_TOLERANCE_S
    latest_s = usual_s * DURATION_FACTOR + parameters.duration_tolerance_s
    if earliest_s <= duration_s <= latest_s:
        return ()
    return (
        f"the sweep took {duration_s:.3f} s, usual are {usual_s:.3f} s; check that nobody "
        "changed the VNA's bandwidth, and its network",
    )


def calibration_remarks(status: CalibrationStatus) -> Tuple[str, ...]:
    """Return a remark unless the calibration is of high accuracy."""
    return () if status is CalibrationStatus.HIGH else (CALIBRATION_REMARKS[status],)


def repetition_remarks(failures: Sequence[Exception]) -> Tuple[str, ...]:
    """Return remarks that tell how often the sweep was repeated, and each reason once."""
    # A dictionary keeps the order.
    reasons = list(dict.fromkeys(str(failure) for failure in failures))[:MOST_REASONS]
    if not reasons:
        return ()
    times = "once" if len(failures) == 1 else f"{len(failures)} times"
    first = f"the sweep was repeated {times}: {reasons[0]}"
    return (first, *(f"the sweep also failed with: {reason}" for reason in reasons[1:]))


class TraceQuality:
    """Judges the traces of one configured sweep, one after the other."""

    def __init__(self, parameters: VnaParameters) -> None:
        self._parameters = parameters
        self._durations_s: Deque[float] = deque(maxlen=MOST_SWEEPS)

    def remarks(
        self, sweep: Sweep, calibration: CalibrationStatus, failures: Sequence[Exception]
    ) -> Tuple[str, ...]:
        """Return what is remarkable about a sweep, and remember how long it took.

        Args:
            sweep: The sweep.
            calibration: State of the calibration right after it.
            failures: Why it had to be repeated, each time.
        """
        remarks = (
            level_remarks(sweep, self._parameters)
            + flat_remarks(sweep, self._parameters)
            + duration_remarks(sweep.duration_s, self._usual_s(), self._parameters)
            + calibration_remarks(calibration)
            + repetition_remarks(failures)
        )
        self._durations_s.append(sweep.duration_s)
        return tuple(storable_remark(remark) for remark in remarks)

    def _usual_s(self) -> Optional[float]:
        if len(self._durations_s) < FEWEST_SWEEPS:
            return None
        return statistics.median(self._durations_s)
