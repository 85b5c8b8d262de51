"""The quality of a trace: data that are refused, and remarks that are stored with it.

A remark never causes a trace to be lost: it shows a technician what to check, and an analyst
what to doubt. Only numbers that no measurement can give are refused.
"""

from __future__ import annotations

from typing import Any, Iterable, Iterator, Mapping, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message, in_a_row, numeral
from gpr20_survey.faults import NOT_CALIBRATED, VNA_DOUBTFUL
from gpr20_survey.trace.sweep import CalibrationStatus, Sweep, SweepSettings, storable_remark
from gpr20_survey.trace.utc_time import US_PER_S
from gpr20_vna_acquisition.errors import VnaCalibrationError, VnaDataError, VnaError
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

# Successive points that have the bits of the sweep before. Noise changes every point.
OLD_POINTS = 3


def refuse_impossible(sweep: Sweep) -> None:
    """Refuse data that no measurement can give.

    Raises:
        VnaDataError: Every number is zero, or the imaginary part is a copy of the real one.
    """
    if not (sweep.s21_real.any() or sweep.s21_imag.any()):
        raise VnaDataError(Message("every number of the trace is zero; nothing was measured"))
    if (sweep.s21_real == sweep.s21_imag).all():
        raise VnaDataError(Message("the imaginary part of the trace is a copy of its real part"))


def has_old_points(
    numbers: np.ndarray, before: Optional[np.ndarray], to_the_last: bool = False
) -> bool:
    """Return whether a part of the data is that of the sweep before, to the last bit.

    An instrument that is read before a sweep has ended answers with new points up to some
    frequency, and old points from there on.

    Args:
        numbers: Real and imaginary part of each point in turn.
        before: Those of the sweep before; None if they are not known.
        to_the_last: Whether a single old point at the end counts; coarsely rounded numbers can be
            equal by chance.
    """
    if before is None or len(before) != len(numbers):
        return False
    same = (numbers.reshape(-1, 2) == before.reshape(-1, 2)).all(axis=1)
    run = min(OLD_POINTS, len(same))
    if to_the_last and same[-1]:
        return True
    return bool(np.convolve(same, np.ones(run), "valid").max() >= run)


def timed_sweep(
    settings: SweepSettings, numbers: np.ndarray, started_us: int, duration_s: float
) -> Sweep:
    """Return the sweep of these data: real and imaginary part of each point in turn.

    Args:
        settings: With which it was measured.
        numbers: The data.
        started_us: When it was triggered [us since 1970, UTC].
        duration_s: How long it took by a monotonic clock [s]: the time of day may be corrected
            meanwhile.
    """
    return Sweep(
        frequency_hz=settings.frequencies_hz(),
        s21_real=numbers[0::2].copy(),
        s21_imag=numbers[1::2].copy(),
        sweep_started_us=started_us,
        sweep_ended_us=started_us + round(duration_s * US_PER_S),
        quality=(),
        analyzer=settings.analyzer,
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
    meaning, calibrated = status.meaning, details.get("parameters", ())
    if status is CalibrationStatus.NONE and calibrated and "S21" not in calibrated:
        meaning = Message("it covers {calibrated}, not S21", calibrated=", ".join(calibrated))
    return Message(
        "the VNA's calibration status is {status} ({meaning}); calibrate it, or change "
        "accepted_calibrations (now {accepted})",
        status=int(status),
        meaning=meaning,
        accepted=listed,
    ).with_fault(CONFIGURATION if status is CalibrationStatus.NOT_REPORTED else NOT_CALIBRATED)


def calibration_lost(settings: Iterable[Message]) -> VnaCalibrationError:
    """Return the error of an analyzer that lost its calibration when these settings were made."""
    return VnaCalibrationError(
        Message(
            "the VNA lost its calibration when it was set up ({settings}); calibrate it now, with "
            "these settings, then start or resume: they are not written again",
            settings=in_a_row(settings),
        )
    )


def data_remarks(sweep: Sweep, parameters: VnaParameters) -> Iterator[Message]:
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


def calibration_remarks(status: CalibrationStatus) -> Tuple[Message, ...]:
    """Return a remark unless the calibration's accuracy is high, or never known."""
    if status in (CalibrationStatus.HIGH, CalibrationStatus.NOT_REPORTED):
        return ()
    remark = Message("the VNA's calibration: {meaning}", meaning=status.meaning)
    fault = NOT_CALIBRATED if status is CalibrationStatus.NONE else NOT_CALIBRATED.as_warning()
    return (remark.with_fault(fault),)


def retry_remarks(failures: Sequence[VnaError]) -> Tuple[Message, ...]:
    """Return a remark on how often a sweep was repeated, and why at first; none if it was not."""
    if not failures:
        return ()
    times, reason = len(failures), failures[0].message
    return (Message("the sweep was repeated {times} times: {reason}", times=times, reason=reason),)


def stored_remarks(remarks: Sequence[Message]) -> Tuple[str, ...]:
    """Return remarks as they are stored with a trace, in English."""
    return tuple(storable_remark(str(remark)) for remark in remarks)
