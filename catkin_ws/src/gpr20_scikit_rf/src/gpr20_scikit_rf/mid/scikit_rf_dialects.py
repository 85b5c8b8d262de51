"""How each class of scikit-rf sets up, triggers and reads one trace of S21.

Only properties that cannot change anything else are used. The `sweep` and `get_...` methods of
scikit-rf are not: they write settings such as the sweep time, or leave the analyzer sweeping by
itself before the data are read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Type

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace.sweep import SweepSettings

S21 = "S21"
# Of a measurement of S21 that the analyzer does not have yet.
MEASUREMENT = "GPR20_S21"
IF_BANDWIDTH = Message("the IF bandwidth")
# An average could have sweeps from before a move.
AVERAGING = Message("averaging")


@dataclass(frozen=True)
class Setting:
    """One setting of the analyzer.

    Attributes:
        name: What it is, for the operator.
        value: The value wanted.
        read: Returns the present value from the object of scikit-rf.
        write: Sets the value.
        matters_to_calibration: Whether a calibration made with another value may not apply.
    """

    name: Message
    value: Any
    read: Callable[[Any], Any]
    write: Callable[[Any], None]
    matters_to_calibration: bool = False


class Dialect:
    """An analyzer whose traces have names: one of S21 is used, or made if there is none.

    `vna` is an object of the class of scikit-rf.
    """

    # The command that triggers one sweep.
    trigger = ""
    # The property that says how it sweeps, held for a trigger and by itself.
    mode = "sweep_mode"
    held: Any = None
    continuous: Any = None

    def part(self, vna: Any) -> Any:
        """Return the part of the object that has the properties of the sweep."""
        return vna.ch1

    def hold(self) -> Setting:
        """Return the setting with which the analyzer sweeps only when triggered."""
        return self.own(Message("continuous sweep"), self.mode, self.held)

    def release(self, vna: Any) -> None:
        """Let the analyzer sweep by itself."""
        setattr(self.part(vna), self.mode, self.continuous)

    def set_format(self, vna: Any) -> None:
        """Select how numbers are transferred, as both ends must: doubles, with their byte order."""
        vna.query_format = type(vna.query_format).BINARY_64

    def sweep(self, vna: Any) -> str:
        """Trigger one sweep and return what the analyzer answers to `*OPC?` when it has ended."""
        # In one message: two small ones wait for each other in some networks.
        return str(vna.query(f"{self.trigger};*OPC?")).strip()

    def data(self, vna: Any) -> np.ndarray:
        """Return the data of the trace."""
        return np.asarray(self.part(vna).active_trace_sdata, dtype=np.complex128)

    def if_bandwidth(self, value_hz: float) -> Setting:
        """Return the setting of the IF bandwidth [Hz]."""
        return self.own(IF_BANDWIDTH, "if_bandwidth", round(value_hz), True)

    def measured_parameter(self, vna: Any) -> str:
        """Return the S-parameter of the trace that `data` reads."""
        selected = vna.query("CALC1:PAR:SEL?").strip("\"' \r\n")
        return self._measurements(vna).get(selected, "")

    def select_s21(self, vna: Any) -> None:
        """Make the trace that `data` reads one of S21."""
        found = [name for name, what in self._measurements(vna).items() if what == S21]
        if not found:
            self.part(vna).create_measurement(MEASUREMENT, S21)
        vna.active_measurement = found[0] if found else MEASUREMENT

    def more_settings(self) -> List[Setting]:
        """Return what the data of this class depend on beside what they do of any."""
        return [
            self.own(Message("the sweep type"), "sweep_type", "LIN", True),
            self.own(AVERAGING, "averaging_on", False),
        ]

    def settings(self, sweep: SweepSettings) -> List[Setting]:
        """Return everything that the data depend on; what `sweep` leaves open is not in it."""
        start_hz, stop_hz = round(sweep.start_frequency_hz), round(sweep.stop_frequency_hz)
        found = [
            self.hold(),
            self.own(Message("the start frequency"), "freq_start", start_hz, True),
            self.own(Message("the stop frequency"), "freq_stop", stop_hz, True),
            self.own(Message("the number of points"), "npoints", sweep.points, True),
            *self.more_settings(),
            Setting(Message("the S-parameter"), S21, self.measured_parameter, self.select_s21),
        ]
        if sweep.analyzer.if_bandwidth_hz:
            found.append(self.if_bandwidth(sweep.analyzer.if_bandwidth_hz))
        return found

    def own(
        self, name: Message, attribute: str, value: Any, matters_to_calibration: bool = False
    ) -> Setting:
        """Return the setting of a property of the part."""

        def read(vna: Any) -> Any:
            found = getattr(self.part(vna), attribute)
            return getattr(found, "value", found)

        def write(vna: Any) -> None:
            setattr(self.part(vna), attribute, value)

        return Setting(name, value, read, write, matters_to_calibration)

    def _measurements(self, vna: Any) -> Dict[str, str]:
        return {name.strip(): what.strip() for name, what in self.part(vna).measurements}


class Pna(Dialect):
    """Keysight PNA, PNA-L and PNA-X."""

    held, continuous = "HOLD", "CONT"
    trigger = "SENS1:SWE:MODE SING"

    def more_settings(self) -> List[Setting]:
        """Return what the data of this class depend on beside what they do of any."""
        return [
            *super().more_settings(),
            Setting(
                Message("the trigger"),
                "IMM",
                lambda vna: vna.trigger_source.value,
                lambda vna: setattr(vna, "trigger_source", "IMM"),
            ),
        ]


class Zva(Dialect):
    """Rohde & Schwarz ZVA and ZNA."""

    held, continuous = "0", "1"
    trigger = "INIT1:IMM"


class FieldFox(Dialect):
    """Keysight FieldFox in its network analyzer mode, without channels; its trace 1 is used.

    scikit-rf does not know all of its IF bandwidths (3 kHz is missing), and has no property for
    averaging: both are set with the commands of the analyzer itself.
    """

    mode, held, continuous = "is_continuous", False, True
    trigger = "INIT:IMM"

    def part(self, vna: Any) -> Any:
        """Return the object itself."""
        return vna

    def more_settings(self) -> List[Setting]:
        """Return what scikit-rf reports; it does not the sweep type."""
        return [
            Setting(
                AVERAGING,
                1,
                lambda vna: max(1, int(float(vna.query("SENS:AVER:COUN?")))),
                lambda vna: vna.write("SENS:AVER:COUN 1"),
            )
        ]

    def measured_parameter(self, vna: Any) -> str:
        """Return the S-parameter of trace 1."""
        return str(vna.get_measurement_parameter(1)).strip("\"' \r\n")

    def select_s21(self, vna: Any) -> None:
        """Make trace 1 one of S21."""
        vna.define_measurement(1, S21)

    def set_format(self, vna: Any) -> None:
        """Select text: scikit-rf does not set the byte order of numbers for this analyzer."""
        vna.query_format = type(vna.query_format).ASCII

    def data(self, vna: Any) -> np.ndarray:
        """Return the data of trace 1, which is selected in the same message."""
        numbers = vna.query_values("CALC:PAR1:SEL;:CALC:DATA:SDATA?", complex_values=True)
        return np.asarray(numbers, dtype=np.complex128)

    def if_bandwidth(self, value_hz: float) -> Setting:
        """Return the setting of the IF bandwidth [Hz]."""
        return Setting(
            IF_BANDWIDTH,
            value_hz,
            lambda vna: float(vna.query("SENS:BWID?")),
            lambda vna: vna.write(f"SENS:BWID {round(value_hz)}"),
            matters_to_calibration=True,
        )


# By the classes of scikit-rf, as named below `skrf.vi.vna`.
DIALECTS: Dict[str, Type[Dialect]] = {
    "keysight.PNA": Pna,
    "keysight.FieldFox": FieldFox,
    "rohde_schwarz.ZVA": Zva,
    "rohde_schwarz.ZNA": Zva,
}
