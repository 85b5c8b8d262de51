"""The quality of a trace: remarks that are stored with it, and data that are refused.

A remark never causes a trace to be lost: it shows a technician what to check, and an analyst
what to doubt. Only numbers that no measurement can give are refused.
"""

from __future__ import annotations

import statistics
from collections import deque
from typing import Any, Deque, Iterable, Iterator, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message, in_a_row, numeral
from gpr20_survey.faults import NOT_CALIBRATED, VNA_DOUBTFUL, VNA_FAILED
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep import Sweep, storable_remark
from gpr20_vna_acquisition.errors import VnaCalibrationError, VnaDataError, VnaError
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# A duration is unusual if it differs from the usual one by more than this factor.
DURATION_FACTOR = 2.0
# The measured duration of a quick sweep depends on polling and on the computer [s].
EARLY_TOLERANCE_S = 0.05
# How many sweeps are needed before one can be unusual, and how many are remembered.
FEWEST_SWEEPS, MOST_SWEEPS = 5, 25
# How many reasons for retries are reported for one sweep, one remark each.
MOST_REASONS = 8

CALIBRATION_REMARKS = {
    CalibrationStatus.NONE: Message(
        "the VNA is not calibrated; calibrate it before you continue"
    ).with_fault(NOT_CALIBRATED),
    CalibrationStatus.MODERATE_POWER: Message(
        "the calibration's accuracy is moderate: power level changed since calibration"
    ).with_fault(NOT_CALIBRATED.as_warning()),
    CalibrationStatus.MODERATE_TEMPERATURE: Message(
        "the calibration's accuracy is moderate: the VNA's temperature changed by more than 5 "
        "degrees since calibration"
    ).with_fault(NOT_CALIBRATED.as_warning()),
    CalibrationStatus.LOW: Message(
        "the calibration's accuracy is low: the VNA's temperature changed by more than 10 degrees "
        "since calibration; calibrate it again"
    ).with_fault(NOT_CALIBRATED.as_warning()),
}


def refuse_impossible(sweep: Sweep) -> None:
    """Refuse data that no measurement can give.

    Raises:
        VnaDataError: Every number is zero, or the imaginary part is a copy of the real one.
    """
    if not (sweep.s21_real.any() or sweep.s21_imag.any()):
        raise VnaDataError(Message("every number of the trace is zero; nothing was measured"))
    if (sweep.s21_real == sweep.s21_imag).all():
        raise VnaDataError(Message("the imaginary part of the trace is a copy of its real part"))


def has_same_data(sweep: Sweep, other: Sweep) -> bool:
    """Return whether two sweeps have the same bits at every point."""
    return np.array_equal(sweep.s21_real, other.s21_real) and np.array_equal(
        sweep.s21_imag, other.s21_imag
    )


def calibration_refusal(
    status: CalibrationStatus, parameters: VnaParameters, details: Mapping[str, Any]
) -> Optional[Message]:
    """Return why no survey is allowed with this calibration; None if it is allowed.

    `details` are what else the analyzer says of it.
    """
    if status in parameters.accepted_calibrations:
        return None
    listed = ", ".join(str(int(one)) for one in parameters.accepted_calibrations)
    if status is CalibrationStatus.NOT_REPORTED:
        return Message(
            "the VNA does not report its calibration; to measure with what the operator "
            "calibrated, add {status} to accepted_calibrations (now {accepted})",
            status=int(status),
            accepted=listed,
        ).with_fault(CONFIGURATION)
    calibrated = details.get("parameters", ())
    if status is CalibrationStatus.NONE and calibrated and "S21" not in calibrated:
        return Message(
            "the VNA's calibration covers {calibrated}, not S21; calibrate the transmission from "
            "port 1 to port 2",
            calibrated=", ".join(calibrated),
        ).with_fault(NOT_CALIBRATED)
    return Message(
        "the VNA's calibration status is {status} ({meaning}); calibrate it, or change "
        "accepted_calibrations (now {accepted})",
        status=int(status),
        meaning=status.meaning,
        accepted=listed,
    ).with_fault(NOT_CALIBRATED)


def calibration_lost(settings: Iterable[Message]) -> VnaCalibrationError:
    """Return the error of an analyzer that lost its calibration when these settings were made."""
    return VnaCalibrationError(
        Message(
            "the VNA lost its calibration when it was set up ({settings}); calibrate it now, with "
            "these settings, then start or resume: they are not written again",
            settings=in_a_row(settings),
        )
    )


def level_remarks(sweep: Sweep, parameters: VnaParameters) -> Iterator[Message]:
    """Yield remarks on the magnitude of S21."""
    with np.errstate(divide="ignore"):
        levels_db = 20.0 * np.log10(np.hypot(sweep.s21_real, sweep.s21_imag))
    median_db, largest_db = float(np.median(levels_db)), float(levels_db.max())
    if median_db < parameters.min_level_db:
        yield Message(
            "S21 is weak: median {level} dB, expected at least {limit_db:g} dB; check that "
            "the cables of both antennas are tight",
            # It can be infinite, which JSON does not know.
            level=numeral(median_db, ".1f"),
            limit_db=parameters.min_level_db,
        ).with_fault(VNA_DOUBTFUL)
    if largest_db > parameters.max_level_db:
        yield Message(
            "S21 is strong: up to {level} dB, expected at most {limit_db:g} dB; the receiver "
            "may be overloaded, or the calibration may be for another setup",
            level=numeral(largest_db, ".1f"),
            limit_db=parameters.max_level_db,
        ).with_fault(VNA_DOUBTFUL)


def flat_remarks(sweep: Sweep, parameters: VnaParameters) -> Iterator[Message]:
    """Yield a remark if successive points are identical to the last bit; noise never is."""
    changes = (np.diff(sweep.s21_real) != 0.0) | (np.diff(sweep.s21_imag) != 0.0)
    edges = np.concatenate(([-1], np.flatnonzero(changes), [len(changes)]))
    longest = int(np.diff(edges).max())
    if longest >= parameters.same_points:
        yield Message(
            "{same} of {points} points in a row are identical; check that the VNA sweeps and is "
            "not in zero span",
            same=longest,
            points=len(sweep.s21_real),
        ).with_fault(VNA_FAILED.as_warning())


def duration_remarks(
    duration_s: float, usual_s: Optional[float], parameters: VnaParameters
) -> Iterator[Message]:
    """Yield a remark if a sweep took much longer or shorter than usual [s], if that is known."""
    if usual_s is None:
        return
    earliest_s = usual_s / DURATION_FACTOR - EARLY_TOLERANCE_S
    latest_s = usual_s * DURATION_FACTOR + parameters.duration_tolerance_s
    if not earliest_s <= duration_s <= latest_s:
        yield Message(
            "the sweep took {duration_s:.3f} s, typically {usual_s:.3f} s; check the VNA's "
            "bandwidth setting and its network",
            duration_s=duration_s,
            usual_s=usual_s,
        ).with_fault(VNA_DOUBTFUL)


def calibration_remarks(status: CalibrationStatus) -> Tuple[Message, ...]:
    """Return a remark unless the calibration's accuracy is high, or never known."""
    return (CALIBRATION_REMARKS[status],) if status in CALIBRATION_REMARKS else ()


def retry_remarks(failures: Sequence[VnaError]) -> Tuple[Message, ...]:
    """Return remarks on how often the sweep was repeated, and each reason once."""
    # A dictionary preserves the order.
    reasons = list(dict.fromkeys(failure.message for failure in failures))[:MOST_REASONS]
    if not reasons:
        return ()
    if len(failures) == 1:
        return (Message("the sweep was repeated once: {reason}", reason=reasons[0]),)
    first = Message(
        "the sweep was repeated {times} times: {reason}", times=len(failures), reason=reasons[0]
    )
    others = (Message("the sweep also failed: {reason}", reason=reason) for reason in reasons[1:])
    return (first, *others)


def stored_remarks(remarks: Sequence[Message]) -> Tuple[str, ...]:
    """Return remarks as they are stored with a trace, in English."""
    return tuple(storable_remark(str(remark)) for remark in remarks)


class TraceQuality:
    """Judges the traces of one configured sweep, one after the other."""

    def __init__(self, parameters: VnaParameters) -> None:
        self._parameters = parameters
        self._durations_s: Deque[float] = deque(maxlen=MOST_SWEEPS)

    def remarks(self, sweep: Sweep, failures: Sequence[VnaError]) -> Tuple[Message, ...]:
        """Return the remarks on a sweep, which had to be repeated for each of these failures."""
        known = len(self._durations_s) >= FEWEST_SWEEPS
        usual_s = statistics.median(self._durations_s) if known else None
        self._durations_s.append(sweep.duration_s)
        return (
            *level_remarks(sweep, self._parameters),
            *flat_remarks(sweep, self._parameters),
            *duration_remarks(sweep.duration_s, usual_s, self._parameters),
            *retry_remarks(failures),
        )
