"""How each class of scikit-rf sets up, triggers and reads one trace of S21.

Only properties that cannot change anything else are used. The `sweep` and `get_...` methods of
scikit-rf are not: they write settings such as the sweep time, or leave the analyzer sweeping by
itself before the data are read.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Callable, Dict, List, Optional, Type

import numpy as np

from gpr20_common.message import Message
from gpr20_scikit_rf.mid.scikit_rf_options import ScikitRfClass
from gpr20_survey.trace.sweep_settings import SweepSettings

S21 = "S21"
# Of a measurement of S21 that the analyzer does not have yet.
MEASUREMENT = "GPR20_S21"


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
    """What the classes have in common; `vna` is an object of the class."""

    # Module that an old scikit-rf does not have.
    needs = ""
    # The command that triggers one sweep.
    trigger = ""
    # What the class calls a linear sweep; empty if it cannot say how it sweeps.
    linear = ""

    def sweep_part(self, vna: Any) -> Any:
        """Return the part of the object that has the properties of the sweep."""
        return vna.ch1

    def hold(self) -> Setting:
        """Return the setting with which the analyzer sweeps only when triggered."""
        raise NotImplementedError

    def release(self, vna: Any) -> None:
        """Let the analyzer sweep by itself."""
        raise NotImplementedError

    def measured_parameter(self, vna: Any) -> str:
        """Return the S-parameter of the trace that `data` reads."""
        raise NotImplementedError

    def select_s21(self, vna: Any) -> None:
        """Make the trace that `data` reads one of S21."""
        raise NotImplementedError

    def set_format(self, vna: Any) -> None:
        """Select how numbers are transferred; both ends must agree on it."""
        raise NotImplementedError

    def sweep(self, vna: Any) -> str:
        """Trigger one sweep and return what the analyzer answers to `*OPC?` when it has ended."""
        # In one message: two small ones wait for each other in some networks.
        return str(vna.query(f"{self.trigger};*OPC?")).strip()

    def data(self, vna: Any) -> np.ndarray:
        """Return the data of the trace."""
        return np.asarray(self.sweep_part(vna).active_trace_sdata, dtype=np.complex128)

    def sweep_time_s(self, vna: Any) -> float:
        """Return how long the analyzer says that one sweep takes [s]."""
        return float(self.sweep_part(vna).sweep_time)

    def if_bandwidth_hz(self, vna: Any) -> float:
        """Return the IF bandwidth [Hz]."""
        return float(self.sweep_part(vna).if_bandwidth)

    def set_if_bandwidth(self, vna: Any, bandwidth_hz: int) -> None:
        """Set the IF bandwidth [Hz]."""
        self.sweep_part(vna).if_bandwidth = bandwidth_hz

    def averages(self, vna: Any) -> int:
        """Return the number of sweeps that make one trace."""
        part = self.sweep_part(vna)
        return int(part.averaging_count) if part.averaging_on else 1

    def set_averages(self, vna: Any, averages: int) -> None:
        """Set the number of sweeps that make one trace."""
        part = self.sweep_part(vna)
        if averages > 1:
            part.averaging_count = averages
        part.averaging_on = averages > 1

    def triggers(self, vna: Any, averages: int) -> int:
        """Return how many sweeps must be triggered for one trace."""
        return averages

    def clear_averages(self, vna: Any) -> None:
        """Begin a new average: nothing that was measured before may be in it."""
        self.sweep_part(vna).clear_averaging()

    def settings(self, sweep: SweepSettings) -> List[Setting]:
        """Return everything that the data depend on; what `sweep` leaves open is not in it."""
        wanted = sweep.analyzer
        found = [
            self.hold(),
            self._own(Message("the start frequency"), "freq_start", sweep.start_frequency_hz),
            self._own(Message("the stop frequency"), "freq_stop", sweep.stop_frequency_hz),
            self._own(Message("the number of points"), "npoints", sweep.points),
            self._sweep_type(),
            Setting(Message("the S-parameter"), S21, self.measured_parameter, self.select_s21),
        ]
        if wanted.if_bandwidth_hz:
            found.append(
                Setting(
                    Message("the IF bandwidth"),
                    wanted.if_bandwidth_hz,
                    self.if_bandwidth_hz,
                    lambda vna: self.set_if_bandwidth(vna, round(wanted.if_bandwidth_hz)),
                    matters_to_calibration=True,
                )
            )
        if wanted.averages:
            found.append(
                Setting(
                    Message("the number of averages"),
                    wanted.averages,
                    self.averages,
                    lambda vna: self.set_averages(vna, wanted.averages),
                )
            )
        return [setting for setting in found if setting is not None]

    def _own(self, name: Message, attribute: str, value: float) -> Setting:
        whole = round(value)
        return Setting(
            name,
            whole,
            lambda vna: getattr(self.sweep_part(vna), attribute),
            lambda vna: setattr(self.sweep_part(vna), attribute, whole),
            matters_to_calibration=True,
        )

    def _sweep_type(self) -> Optional[Setting]:
        if not self.linear:
            return None
        return Setting(
            Message("the sweep type"),
            self.linear,
            lambda vna: self.sweep_part(vna).sweep_type.value,
            lambda vna: setattr(self.sweep_part(vna), "sweep_type", self.linear),
            matters_to_calibration=True,
        )


class NamedMeasurements(Dialect):
    """Analyzers whose traces have names: one of S21 is used, or made if there is none."""

    linear = "LIN"
    # Of the sweep mode, in which the analyzer sweeps only when triggered, and by itself.
    held, continuous = "", ""

    def hold(self) -> Setting:
        """Return the setting with which the analyzer sweeps only when triggered."""
        return Setting(
            Message("continuous sweep"),
            self.held,
            lambda vna: self.sweep_part(vna).sweep_mode.value,
            lambda vna: setattr(self.sweep_part(vna), "sweep_mode", self.held),
        )

    def release(self, vna: Any) -> None:
        """Let the analyzer sweep by itself."""
        self.sweep_part(vna).sweep_mode = self.continuous

    def measured_parameter(self, vna: Any) -> str:
        """Return the S-parameter of the trace that `data` reads."""
        selected = vna.query("CALC1:PAR:SEL?").strip("\"' \r\n")
        return self._measurements(vna).get(selected, "")

    def select_s21(self, vna: Any) -> None:
        """Make the trace that `data` reads one of S21."""
        found = [name for name, what in self._measurements(vna).items() if what == S21]
        if not found:
            self.sweep_part(vna).create_measurement(MEASUREMENT, S21)
        vna.active_measurement = found[0] if found else MEASUREMENT

    def set_format(self, vna: Any) -> None:
        """Select doubles; the byte order goes with them."""
        vna.query_format = type(vna.query_format).BINARY_64

    def _measurements(self, vna: Any) -> Dict[str, str]:
        return {name.strip(): what.strip() for name, what in self.sweep_part(vna).measurements}


class Pna(NamedMeasurements):
    """Keysight PNA, PNA-L and PNA-X."""

    held, continuous = "HOLD", "CONT"
    trigger = "SENS1:SWE:MODE SING"

    def settings(self, sweep: SweepSettings) -> List[Setting]:
        """Return everything that the data depend on; what `sweep` leaves open is not in it."""
        trigger = Setting(
            Message("the trigger"),
            "IMM",
            lambda vna: vna.trigger_source.value,
            lambda vna: setattr(vna, "trigger_source", "IMM"),
        )
        return [*super().settings(sweep), trigger]

    def triggers(self, vna: Any, averages: int) -> int:
        """Return how many sweeps must be triggered: one if each point is averaged by itself."""
        if averages > 1 and self.sweep_part(vna).averaging_mode.value == "POIN":
            return 1
        return averages


class Zva(NamedMeasurements):
    """Rohde & Schwarz ZVA and ZNA."""

    needs = "skrf.vi.vna.rohde_schwarz.rs_vna"
    held, continuous = "0", "1"
    trigger = "INIT1:IMM"


class FieldFox(Dialect):
    """Keysight FieldFox in its network analyzer mode; its trace 1 is used."""

    trigger = "INIT:IMM"

    def sweep_part(self, vna: Any) -> Any:
        """Return the object itself: this analyzer has no channels."""
        return vna

    def hold(self) -> Setting:
        """Return the setting with which the analyzer sweeps only when triggered."""
        return Setting(
            Message("continuous sweep"),
            False,
            lambda vna: vna.is_continuous,
            lambda vna: setattr(vna, "is_continuous", False),
        )

    def release(self, vna: Any) -> None:
        """Let the analyzer sweep by itself."""
        vna.is_continuous = True

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

    # scikit-rf does not know all IF bandwidths of this analyzer (3 kHz is missing), and has no
    # property for the averages; a trace must not contain sweeps from before a move. Both are set
    # with the commands of the analyzer itself.

    def if_bandwidth_hz(self, vna: Any) -> float:
        """Return the IF bandwidth [Hz]."""
        return float(vna.query("SENS:BWID?"))

    def set_if_bandwidth(self, vna: Any, bandwidth_hz: int) -> None:
        """Set the IF bandwidth [Hz]."""
        vna.write(f"SENS:BWID {bandwidth_hz}")

    def averages(self, vna: Any) -> int:
        """Return the number of sweeps that make one trace."""
        return max(1, int(float(vna.query("SENS:AVER:COUN?"))))

    def set_averages(self, vna: Any, averages: int) -> None:
        """Set the number of sweeps that make one trace."""
        vna.write(f"SENS:AVER:COUN {averages}")

    def clear_averages(self, vna: Any) -> None:
        """Begin a new average: nothing that was measured before may be in it."""
        vna.write("SENS:AVER:CLE")


DIALECTS: Dict[ScikitRfClass, Type[Dialect]] = {
    ScikitRfClass.PNA: Pna,
    ScikitRfClass.FIELDFOX: FieldFox,
    ScikitRfClass.ZVA: Zva,
    ScikitRfClass.ZNA: Zva,
}
