"""What the display shows of complex data, for each graph type."""

from __future__ import annotations

from typing import Callable, Dict

import numpy as np

REFERENCE_OHM = 50.0
# Keeps the logarithm and the quotients finite where nothing is received.
SMALLEST_MAGNITUDE = 1e-20

Display = Callable[[np.ndarray, np.ndarray], np.ndarray]


def interleaved(values: np.ndarray) -> np.ndarray:
    """Return real and imaginary parts in turns."""
    return np.column_stack((values.real, values.imag)).ravel()


def _level_db(values: np.ndarray) -> np.ndarray:
    return 20.0 * np.log10(np.maximum(np.abs(values), SMALLEST_MAGNITUDE))


def _phase_deg(values: np.ndarray) -> np.ndarray:
    return np.degrees(np.angle(values))


def _standing_wave_ratio(values: np.ndarray) -> np.ndarray:
    magnitude = np.minimum(np.abs(values), 1.0 - 1e-6)
    return (1.0 + magnitude) / (1.0 - magnitude)


def _impedance_ohm(values: np.ndarray) -> np.ndarray:
    difference = 1.0 - values
    safe = np.where(np.abs(difference) < SMALLEST_MAGNITUDE, SMALLEST_MAGNITUDE, difference)
    return REFERENCE_OHM * (1.0 + values) / safe


def _admittance_siemens(values: np.ndarray) -> np.ndarray:
    return 1.0 / _impedance_ohm(np.where(values == -1.0, -1.0 + 1e-12, values))


def _group_delay_s(frequency_hz: np.ndarray, values: np.ndarray) -> np.ndarray:
    if len(values) < 2 or frequency_hz[0] == frequency_hz[-1]:
        return np.zeros(len(values))
    return -np.gradient(np.unwrap(np.angle(values)), frequency_hz) / (2.0 * np.pi)


DISPLAYS: Dict[str, Display] = {
    "LMAG": lambda _f, values: _level_db(values),
    "LM/2": lambda _f, values: _level_db(values) / 2.0,
    "SWR": lambda _f, values: _standing_wave_ratio(values),
    "PHAS": lambda _f, values: _phase_deg(values),
    "REAL": lambda _f, values: values.real,
    "IMAG": lambda _f, values: values.imag,
    "GDEL": _group_delay_s,
    "SMIT": lambda _f, values: interleaved(_impedance_ohm(values)),
    "ISM": lambda _f, values: interleaved(_admittance_siemens(values)),
    "LINP": lambda _f, values: interleaved(np.abs(values) + 1j * _phase_deg(values)),
    "LOGP": lambda _f, values: interleaved(_level_db(values) + 1j * _phase_deg(values)),
    "RIMP": lambda _f, values: _impedance_ohm(values).real,
    "IIMP": lambda _f, values: _impedance_ohm(values).imag,
}


def display_data(frequency_hz: np.ndarray, values: np.ndarray, graph_type: str) -> np.ndarray:
    """Return the numbers of a graph type, two per point where it is a complex one.

    Args:
        frequency_hz: Frequencies [Hz].
        values: Complex data.
        graph_type: Short form of the format's keyword, such as "LMAG".
    """
    return DISPLAYS[graph_type](frequency_hz, values.astype(np.complex128))
