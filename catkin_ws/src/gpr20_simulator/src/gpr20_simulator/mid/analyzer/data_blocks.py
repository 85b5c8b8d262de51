"""Answers that are blocks of data: traces, the frequency list and the preamble."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable

import numpy as np

from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.analyzer.vna_settings import (
    BANDWIDTHS_HZ,
    PARAMETERS,
    POWERS,
    REAL_32,
    Numbers,
    VnaSettings,
)
from gpr20_simulator.mid.faults import FaultBoard, VnaFault
from gpr20_simulator.mid.world.scene import InstrumentScene

# After the point; 8 keep a float32 exactly.
TRACE_DIGITS, FREQUENCY_DIGITS = 8, 12
TRUNCATED_BYTES = 9
NAN_EVERY = 50
# Of a plug that is loose: 3.1 dB less, 20 degrees.
LOOSE_PLUG_FACTOR = np.complex64(0.7 * np.exp(-1j * np.pi / 9.0))
# S11 and S22: good enough to be distinguished from S21, which is all that a survey needs of them.
REFLECTION = np.complex64(0.3)
QUARTERS_PER_DEGREE = 4
# The keys of a preamble that are for all four traces have these numbers in 4 bits for each.
DOMAIN_NUMBERS = {"FREQ": 0, "TIME": 1, "DIST": 2, "FGT": 3}
BITS_PER_TRACE = 4


@dataclass(frozen=True)
class DataBlock:
    """What answers a query for data.

    Attributes:
        kind: What was asked for: sdat, freq or preamble.
        data: Header and content as they are sent.
    """

    kind: str
    data: bytes


class DataBlocks:
    """Makes them from what the receiver holds."""

    def __init__(self, sweeper: Sweeper, faults: FaultBoard, description: InstrumentScene) -> None:
        self._sweeper = sweeper
        self._faults = faults
        self._description = description

    def sweep(self, settings: VnaSettings, numbers: Numbers) -> DataBlock:
        """Return the complex data of a trace, real and imaginary parts in turns.

        Raises:
            ScpiError: There is no such trace.
        """
        values = self._values(settings.trace(numbers).parameter)
        parts = np.column_stack((values.real, values.imag)).ravel()
        if self._faults.strikes(VnaFault.NAN):
            parts = parts.astype(np.float64)
            parts[::NAN_EVERY] = np.nan
        content = _content(parts, settings, TRACE_DIGITS)
        lost = TRUNCATED_BYTES if self._faults.strikes(VnaFault.TRUNCATE) else 0
        return DataBlock("sdat", _header(content) + content[: len(content) - lost])

    def frequencies(self, settings: VnaSettings, numbers: Numbers) -> DataBlock:
        """Return the frequencies of a trace [Hz].

        Raises:
            ScpiError: There is no such trace.
        """
        settings.trace(numbers)
        frequency_hz, _values = self._sweeper.snapshot()
        content = _content(frequency_hz, settings, FREQUENCY_DIGITS)
        return DataBlock("freq", _header(content) + content)

    def preamble(
        self, settings: VnaSettings, number: int, serial: str, is_corrected: bool
    ) -> DataBlock:
        """Return the state of the instrument as names and values, for a trace that exists."""
        one, traces = self._description, settings.traces
        trace = settings.trace((number,))
        pairs = (
            ("SN", serial),
            ("APP_VER", one.firmware),
            ("S_TYPE", PARAMETERS.index(trace.parameter)),
            ("TRACE_S_TYPES", _of_all(PARAMETERS.index(one.parameter) for one in traces)),
            ("DOMAIN", DOMAIN_NUMBERS[trace.domain]),
            ("TRACE_DOMAIN_TYPES", _of_all(DOMAIN_NUMBERS[one.domain] for one in traces)),
            ("TRACE_MATH_TYPES", 0),
            ("SMOOTHING_PERCENT", 0),
            ("TOTAL_TRACE", settings.trace_total),
            ("SWEEP_TYPE", int(self._sweeper.is_continuous)),
            ("AVERAGING_FACTOR", settings.averages),
            ("IFBW", BANDWIDTHS_HZ.index(settings.bandwidth_hz)),
            ("RF_SOURCE_POWER", POWERS.index(settings.power)),
            # The instrument says 0 for on.
            ("CAL_CORRECTION", int(not is_corrected)),
            ("CURRENT_TEMPERATURE", round(one.temperature_c * QUARTERS_PER_DEGREE)),
            (f"TRACE_{number}_START_FREQ", f"{settings.start_hz / 1e6:.6f}"),
            (f"TRACE_{number}_STOP_FREQ", f"{settings.stop_hz / 1e6:.6f}"),
            (f"TRACE_{number}_DSP_DATA_POINTS", settings.points),
        )
        content = ",".join(f"{name}={value}" for name, value in pairs).encode("ascii")
        return DataBlock("preamble", _header(content) + content)

    def _values(self, parameter: str) -> np.ndarray:
        _frequency_hz, transmission = self._sweeper.snapshot()
        if parameter in ("S21", "S12"):
            # Antennas and soil are reciprocal.
            is_loose = self._faults.is_on(VnaFault.LOOSE_PLUG)
            return transmission * LOOSE_PLUG_FACTOR if is_loose else transmission
        return np.full(len(transmission), REFLECTION)


def _content(values: np.ndarray, settings: VnaSettings, digits: int) -> bytes:
    if settings.data_format == REAL_32:
        return values.astype("<f4").tobytes()
    return "".join(f"{one:.{digits}E}," for one in values.tolist()).encode("ascii")


def _header(content: bytes) -> bytes:
    digits = str(len(content))
    return f"#{len(digits)}{digits}".encode("ascii")


def _of_all(numbers: Iterable[int]) -> int:
    return sum(one << (BITS_PER_TRACE * place) for place, one in enumerate(numbers))
