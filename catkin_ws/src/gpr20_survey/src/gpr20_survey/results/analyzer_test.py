"""What a test of the analyzer has found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

from gpr20_common.message import Message


@dataclass(frozen=True)
class AnalyzerTest:
    """What a test of the analyzer has found, up to its first failure; None: it had none.

    The calibration is the name of a `CalibrationStatus`; another version of the software may know
    more of them.
    """

    address: str
    identity: str = ""
    calibration: str = ""
    points: int = 0
    sweep_duration_s: float = 0.0
    level_db: float = 0.0
    failure: Optional[Message] = None
