"""The calibration of the simulated analyzer, as long as it holds."""

from __future__ import annotations

from gpr20_simulator.mid.analyzer.instrument_scene import NOT_CALIBRATED, InstrumentScene
from gpr20_simulator.mid.analyzer.vna_faults import FaultBoard, VnaFault
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings

ACCURACY_HIGH = 1
ACCURACY_POWER_CHANGED = 2
COLLECTION_COMPLETED = 4
# Writing one of these ends the calibration of an instrument with the fault LOSES_CALIBRATION.
WATCHED_SETTINGS = (
    "[:SENSe]:FREQuency:STARt",
    "[:SENSe]:FREQuency:STOP",
    "[:SENSe]:FREQuency:CENTer",
    "[:SENSe]:FREQuency:SPAN",
    "[:SENSe]:SWEep:POINts",
    "[:SENSe]:SWEep:IFBW",
    ":SOURce:POWer",
)


class Calibration:
    """What the instrument says of its calibration.

    Args:
        description: Which calibration it has.
        faults: What goes wrong now.
    """

    def __init__(self, description: InstrumentScene, faults: FaultBoard) -> None:
        self._description = description
        self._faults = faults

    @property
    def exists(self) -> bool:
        """Whether there is one that can be applied."""
        is_lost = self._faults.has_damaged(VnaFault.LOSES_CALIBRATION)
        return self._description.calibration_accuracy != NOT_CALIBRATED and not is_lost

    @property
    def parameters(self) -> int:
        """The calibrated parameters, as a bit mask."""
        return self._description.calibrated_parameters if self.exists else 0

    @property
    def type(self) -> str:
        """How it was made; empty without one."""
        return self._description.calibration_type if self.exists else ""

    @property
    def is_interpolated(self) -> bool:
        """Whether it is interpolated between its points."""
        return self.exists and self._description.calibration_interpolated

    @property
    def collection(self) -> int:
        """How far the collection of the calibration has got."""
        return COLLECTION_COMPLETED if self.exists else 0

    def is_applied(self, settings: VnaSettings) -> bool:
        """Return whether data are corrected."""
        return settings.is_corrected and self.exists

    def accuracy(self, settings: VnaSettings) -> int:
        """Return how accurate it is with these settings; 0: it is not applied."""
        if not self.is_applied(settings):
            return NOT_CALIBRATED
        accuracy = self._description.calibration_accuracy
        has_other_power = settings.power is not self._description.calibration_power
        if accuracy == ACCURACY_HIGH and has_other_power:
            return ACCURACY_POWER_CHANGED
        return accuracy

    def note_write(self, header: str) -> None:
        """Take note that a setting was written, by the pattern of its header."""
        if header in WATCHED_SETTINGS:
            self._faults.damages(VnaFault.LOSES_CALIBRATION)
