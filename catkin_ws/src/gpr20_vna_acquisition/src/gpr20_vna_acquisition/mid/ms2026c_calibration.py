"""The calibration of an MS2026C, as far as the instrument reports it."""

from __future__ import annotations

from typing import Any, Dict, Optional, Tuple

from gpr20_common.message import Message
from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_vna_acquisition.errors import VnaDataError
from gpr20_vna_acquisition.mid.block_parser import whole_number
from gpr20_vna_acquisition.mid.exchanges import Exchanges
from gpr20_vna_acquisition.mid.preamble import Preamble

ACCURACY_QUERY = ":SENS:CORR:COLL:STAT:ACC?"
CALIBRATED_QUERY = ":SENS:CAL:STAT?"
TYPE_QUERY, INTERPOLATION_QUERY = ":SENS:CORR:COLL:TYPE?", ":SENS:CORR:COLL:INT?"
# The bits of the answer to `CALIBRATED_QUERY`.
CALIBRATED_BITS = {"S11": 1, "S12": 2, "S21": 4, "S22": 8}
NEEDED = "S21"


class Ms2026cCalibration:
    """Asks for the calibration."""

    def __init__(self, exchanges: Exchanges) -> None:
        self._exchanges = exchanges
        # Which S-parameters are calibrated; None if it does not say.
        self._calibrated: Optional[Tuple[str, ...]] = None

    def status(self) -> CalibrationStatus:
        """Return its accuracy; a calibration that lacks S21, when last looked at, is none."""
        status = whole_number(self._exchanges.ask(ACCURACY_QUERY))
        if not CalibrationStatus.NONE <= status <= CalibrationStatus.LOW:
            raise VnaDataError(
                Message(
                    "the VNA reports calibration status {status}; expected 0 to 4", status=status
                )
            )
        lacks_s21 = self._calibrated is not None and NEEDED not in self._calibrated
        return CalibrationStatus.NONE if lacks_s21 else CalibrationStatus(status)

    def look(self) -> None:
        """Ask which S-parameters are calibrated."""
        answer = self._exchanges.ask_detail(CALIBRATED_QUERY)
        if answer is None:
            self._calibrated = None
            return
        mask = whole_number(answer)
        self._calibrated = tuple(name for name, bit in CALIBRATED_BITS.items() if mask & bit)

    def details(self, preamble: Optional[Preamble]) -> Dict[str, Any]:
        """Return all that the instrument says of it, and of what it does with its trace."""
        self.look()
        interpolation = self._exchanges.ask_detail(INTERPOLATION_QUERY)
        found = {
            "parameters": None if self._calibrated is None else list(self._calibrated),
            "type": self._exchanges.ask_detail(TYPE_QUERY),
            "interpolated": None if interpolation is None else interpolation == "1",
        }
        if preamble is not None:
            names = ("is_corrected", "temperature_c", "smoothing_percent", "trace_math")
            found.update((name, getattr(preamble, name)) for name in names)
        return {name: value for name, value in found.items() if value is not None}
