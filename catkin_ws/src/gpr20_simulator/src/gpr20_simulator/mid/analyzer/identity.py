"""What the simulated analyzer says it is."""

from __future__ import annotations

from gpr20_simulator.mid.analyzer.instrument_scene import InstrumentScene
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault

WRONG_IDENTITY = '"Rohde&Schwarz,ZNL6,SIMULATED,1.0"'


class Identity:
    """Answers who is there.

    Args:
        description: The fields of the identity.
        faults: What goes wrong now.
    """

    def __init__(self, description: InstrumentScene, faults: FaultBoard) -> None:
        self._description = description
        self._faults = faults
        self._is_other_unit = False

    @property
    def serial(self) -> str:
        """Serial number."""
        one = self._description
        is_other = self._is_other_unit or self._faults.is_on(VnaFault.SWAPPED)
        return one.other_serial if is_other else one.serial

    def connected(self) -> None:
        """Note that a client connects: it may find another unit at this address."""
        self._is_other_unit = self._faults.strikes(VnaFault.OTHER_SERIAL)

    def text(self) -> str:
        """Return the answer to `*IDN?`."""
        if self._faults.strikes(VnaFault.WRONG_IDENTITY):
            return WRONG_IDENTITY
        one = self._description
        # The instrument wraps its identity in double quotes.
        return f'"{one.manufacturer},{one.model},{self.serial},{one.firmware}"'

    def options(self) -> str:
        """Return the answer to `:SYSTem:OPTions?`."""
        _model, _slash, options = self._description.model.partition("/")
        return options or "NONE"
