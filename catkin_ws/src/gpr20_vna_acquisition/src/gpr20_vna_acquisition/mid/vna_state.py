"""What the driver of the network analyzer tells of itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional, Tuple

from gpr20_survey.trace.calibration import CalibrationStatus
from gpr20_survey.trace.sweep_settings import SweepSettings


@dataclass(frozen=True)
class VnaState:
    """What the driver knows, for reports.

    Attributes:
        address: Where it shall be connected; empty if nowhere.
        identity: What answered there.
        linked: Whether a link is open now. After a failure there is none until the next use.
        sweep: The configured sweep, as the instrument confirmed it.
        sweeps: How many good sweeps were taken.
        repeats: How many attempts of any kind had to be repeated.
        last_sweep_s: How long the last sweep took [s].
        last_quality: Remarks on the last sweep.
        last_error: Why the last attempt failed; empty if it did not.
        link_error: Why the link did not stand when it was last checked; empty if it did.
        calibration: State of the calibration when it was last read; None before.
        wanted: Where the last connection failed and is tried again; empty if it did not fail.
    """

    address: str = ""
    identity: str = ""
    linked: bool = False
    sweep: Optional[SweepSettings] = None
    sweeps: int = 0
    repeats: int = 0
    last_sweep_s: float = 0.0
    last_quality: Tuple[str, ...] = ()
    last_error: str = ""
    link_error: str = ""
    calibration: Optional[CalibrationStatus] = None
    wanted: str = ""

    @property
    def trouble(self) -> str:
        """What is wrong now; empty if nothing is."""
        return self.link_error or self.last_error
