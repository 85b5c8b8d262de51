"""What is for display only: gain and envelope; imaging refuses the result."""

from __future__ import annotations

import enum

import numpy as np
import xarray as xr
from scipy.ndimage import uniform_filter1d

from gpr20_analysis.dataset import A_SCAN, DELAY, SAMPLE_DIMS
from gpr20_analysis.errors import WrongDatasetError
from gpr20_analysis.sentences import with_sentence
from gpr20_common.message import Message

DISPLAY_ONLY = "display_only"
"""Attribute: why the amplitudes are for display only and must not be imaged."""


class Gain(enum.Enum):
    """How late echoes are amplified."""

    LINEAR = "linear"
    """Proportional to the delay: compensates for spreading."""
    EXPONENTIAL = "exponential"
    """A number of decibels per nanosecond: compensates for loss."""
    AGC = "agc"
    """Each value divided by the root mean square of those around it."""


def apply_gain(
    in_time: xr.Dataset, method: Gain = Gain.LINEAR, db_per_ns: float = 1.0, window_s: float = 2e-9
) -> xr.Dataset:
    """Amplify late echoes for display; imaging refuses the result.

    Args:
        in_time: Dataset with `a_scan`.
        method: How the echoes are amplified.
        db_per_ns: Slope of the exponential gain [dB/ns].
        window_s: Width of the window of the automatic gain [s].

    Raises:
        WrongDatasetError: The data are not A-scans.
    """
    values = _a_scans(in_time, "gain")
    delay_s = in_time[DELAY]
    if method is Gain.AGC:
        step_s = float(delay_s[1] - delay_s[0])
        power = _mean_power(values.values, max(1, round(window_s / step_s)))
        raised = values / np.sqrt(power + 1e-12 * power.max())
    elif method is Gain.EXPONENTIAL:
        raised = values * 10.0 ** (db_per_ns * delay_s * 1e9 / 20.0)
    else:
        raised = values * (delay_s / float(delay_s.max()))
    result = in_time.assign({A_SCAN: raised.assign_attrs(values.attrs)})
    reason = Message("gain {method}", method=method.value)
    return result.assign_attrs(with_sentence(result.attrs, DISPLAY_ONLY, reason))


def envelope(in_time: xr.Dataset) -> xr.Dataset:
    """Return the magnitude of A-scans, for display; imaging refuses the result.

    Complex A-scans are analytic. Of real ones, such as those of a time-domain receiver, the
    analytic signal is computed first.

    Args:
        in_time: Dataset with `a_scan`.

    Raises:
        WrongDatasetError: The data are not A-scans.
    """
    from scipy.signal import hilbert  # its import takes half a second

    values = _a_scans(in_time, "envelope")
    traces = values.values if np.iscomplexobj(values) else hilbert(values.values, axis=-1)
    result = in_time.assign({A_SCAN: values.copy(data=np.abs(traces))})
    return result.assign_attrs(with_sentence(result.attrs, DISPLAY_ONLY, Message("envelope")))


def _a_scans(in_time: xr.Dataset, step: str) -> xr.DataArray:
    if A_SCAN not in in_time:
        raise WrongDatasetError(
            Message("the step {step} needs A-scans; apply the step 'time' before it", step=step)
        )
    return in_time[A_SCAN].transpose(*SAMPLE_DIMS, DELAY)


def _mean_power(values: np.ndarray, width: int) -> np.ndarray:
    """Return the mean power over a window around each sample, narrower at the ends."""
    power, every = np.abs(values) ** 2, np.ones(values.shape[-1])
    mean, share = (uniform_filter1d(one, width, mode="constant") for one in (power, every))
    return mean / share
