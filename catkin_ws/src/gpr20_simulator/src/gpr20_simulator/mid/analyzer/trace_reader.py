"""Replies that hold data: traces, the frequency list and the preamble."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Dict, Iterable, Tuple

import numpy as np

from gpr20_simulator.mid.analyzer import scpi
from gpr20_simulator.mid.analyzer.calibration import Calibration
from gpr20_simulator.mid.analyzer.identity import Identity
from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene, Power
from gpr20_simulator.mid.analyzer.sweeper import Sweeper
from gpr20_simulator.mid.analyzer.vna_commands import Numbers, trace_of
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault
from gpr20_simulator.mid.analyzer.vna_settings import (
    BANDWIDTHS_HZ,
    PARAMETERS,
    TRACES,
    DataFormat,
    VnaSettings,
)

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


# INT,32 has no documented scale for these data; this one is the simulator's own.
INTEGER_STEPS_PER_UNIT = 1_000_000
FREQUENCY_DIGITS = 12
TRUNCATED_BYTES = 9
NAN_EVERY = 50
# Of a plug that is loose: 3.1 dB less, 20 degrees.
LOOSE_PLUG_FACTOR = np.complex64(0.7 * np.exp(-1j * np.pi / 9.0))
# S11 and S22 are those of an antenna that reflects alike at all frequencies: good enough
# to be distinguished from S21, which is all that a survey needs of them.
REFLECTION = 0.3
REFLECTION_DELAY_S = 1e-9
QUARTERS_PER_DEGREE = 4
# The keys of a preamble that are for all four traces have these numbers in 4 bits for each.
DOMAIN_NUMBERS = {"FREQ": 0, "TIME": 1, "DIST": 2, "FGT": 3}
BITS_PER_TRACE = 4


def _of_all(numbers: Iterable[int]) -> int:
    return sum(one << (BITS_PER_TRACE * place) for place, one in enumerate(numbers))


def payload(
    values: np.ndarray, data_format: DataFormat, style: InstrumentScene, digits: int
) -> bytes:
    """Return real numbers as the bytes of a block without its header.

    Args:
        values: The numbers, in the order in which they are sent.
        data_format: How.
        style: The details of the instrument's replies.
        digits: Digits after the point in ASCII.
    """
    if data_format is DataFormat.REAL_32:
        return values.astype("<f4").tobytes()
    if data_format is DataFormat.INTEGER_32:
        limits = np.iinfo(np.int32)
        steps = np.nan_to_num(np.rint(values * INTEGER_STEPS_PER_UNIT))
        return np.clip(steps, limits.min, limits.max).astype("<i4").tobytes()
    numbers = values.tolist()
    text = ",".join([f"%.{digits}E"] * len(numbers)) % tuple(numbers)
    return (text + ("," if style.trailing_comma else "")).encode("ascii")


def block_header(length: int, style: InstrumentScene) -> bytes:
    """Return the header of a block of so many bytes."""
    digits = str(length).zfill(style.header_digits)
    return f"#{len(digits)}{digits}".encode("ascii")


@dataclass(frozen=True)
class DataReply:
    """A block that answers a query for data.

    Attributes:
        kind: What was asked for: sdat, fdat, freq or preamble.
        block: Header and payload as they are sent.
    """

    kind: str
    block: bytes


class TraceReader:
    """Makes the replies from what the receiver holds.

    Args:
        sweeper: The receiver.
        faults: What goes wrong now.
        description: The details of the blocks.
        identity: What the preamble says of the instrument.
        calibration: What the preamble says of the correction.
    """

    def __init__(
        self,
        sweeper: Sweeper,
        faults: FaultBoard,
        description: InstrumentScene,
        identity: Identity,
        calibration: Calibration,
    ) -> None:
        self._sweeper = sweeper
        self._faults = faults
        self._description = description
        self._identity = identity
        self._calibration = calibration

    def calculated(self, settings: VnaSettings, numbers: Numbers, argument: str) -> DataReply:
        """Answer `:CALCulate<n>:DATA?`: complex data, or those of the display.

        Raises:
            ScpiError: There is no such trace or no such kind; memories are never filled.
        """
        trace = trace_of(settings, numbers)
        kind = scpi.chosen_keyword(argument, ("SDATa", "FDATa"))
        frequency_hz, values = self._values(trace.parameter)
        if kind == "SDAT":
            return self._data(settings, "sdat", interleaved(values))
        shown = display_data(frequency_hz, values, trace.graph_type)
        return self._data(settings, "fdat", shown)

    def trace_data(self, settings: VnaSettings, argument: str) -> DataReply:
        """Answer `:TRACe:DATA?`: complex data whatever the display shows.

        Raises:
            ScpiError: There is no such trace.
        """
        number = scpi.whole_number_between(argument or "1", 1, TRACES)
        _frequency_hz, values = self._values(trace_of(settings, (number,)).parameter)
        return self._data(settings, "sdat", interleaved(values))

    def frequencies(self, settings: VnaSettings, numbers: Numbers) -> DataReply:
        """Answer `:SENSe<n>:FREQuency:DATA?` [Hz].

        Raises:
            ScpiError: There is no such trace.
        """
        trace_of(settings, numbers)
        frequency_hz, _values = self._sweeper.snapshot()
        content = payload(frequency_hz, settings.data_format, self._description, FREQUENCY_DIGITS)
        return DataReply("freq", block_header(len(content), self._description) + content)

    def preamble(self, settings: VnaSettings, argument: str) -> DataReply:
        """Answer `:TRACe:PREamble?`: the state of the instrument as names and values.

        Raises:
            ScpiError: There is no such trace.
        """
        number = scpi.whole_number_between(argument or "1", 1, TRACES)
        sweep_type = 2 if settings.is_external else int(self._sweeper.is_continuous)
        pairs = (
            ("SN", self._identity.serial),
            ("APP_VER", self._description.firmware),
            ("S_TYPE", PARAMETERS.index(trace_of(settings, (number,)).parameter)),
            ("TRACE_S_TYPES", _of_all(PARAMETERS.index(one.parameter) for one in settings.traces)),
            ("DOMAIN", DOMAIN_NUMBERS[trace_of(settings, (number,)).domain]),
            ("TRACE_DOMAIN_TYPES", _of_all(DOMAIN_NUMBERS[one.domain] for one in settings.traces)),
            ("TRACE_MATH_TYPES", self._description.trace_math),
            ("SMOOTHING_PERCENT", self._description.smoothing_percent),
            ("TOTAL_TRACE", settings.trace_total),
            ("SWEEP_TYPE", sweep_type),
            ("AVERAGING_COUNT", self._sweeper.averaged),
            ("AVERAGING_FACTOR", settings.averages),
            ("IFBW", BANDWIDTHS_HZ.index(settings.bandwidth_hz)),
            ("RF_SOURCE_POWER", int(settings.power is Power.HIGH)),
            # The instrument says 0 for on.
            ("CAL_CORRECTION", int(not self._calibration.is_applied(settings))),
            ("CURRENT_TEMPERATURE", round(self._description.temperature_c * QUARTERS_PER_DEGREE)),
            (f"TRACE_{number}_START_FREQ", f"{settings.start_hz / 1e6:.6f}"),
            (f"TRACE_{number}_STOP_FREQ", f"{settings.stop_hz / 1e6:.6f}"),
            (f"TRACE_{number}_DSP_DATA_POINTS", settings.points),
        )
        content = ",".join(f"{name}={value}" for name, value in pairs).encode("ascii")
        return DataReply("preamble", block_header(len(content), self._description) + content)

    def _values(self, parameter: str) -> Tuple[np.ndarray, np.ndarray]:
        frequency_hz, transmission = self._sweeper.snapshot()
        if parameter in ("S21", "S12"):
            # Antennas and soil are reciprocal.
            if self._faults.is_on(VnaFault.LOOSE_PLUG):
                transmission = transmission * LOOSE_PLUG_FACTOR
            return frequency_hz, transmission
        reflection = REFLECTION * np.exp(-2j * np.pi * frequency_hz * REFLECTION_DELAY_S)
        return frequency_hz, reflection.astype(np.complex64)

    def _data(self, settings: VnaSettings, kind: str, numbers: np.ndarray) -> DataReply:
        if self._faults.strikes(VnaFault.NAN):
            numbers = numbers.astype(np.float64)
            numbers[::NAN_EVERY] = np.nan
        data_format: DataFormat = settings.data_format
        content = payload(numbers, data_format, self._description, self._description.ascii_digits)
        header = block_header(len(content), self._description)
        if self._faults.strikes(VnaFault.TRUNCATE):
            content = content[:-TRUNCATED_BYTES]
        return DataReply(kind, header + content)
