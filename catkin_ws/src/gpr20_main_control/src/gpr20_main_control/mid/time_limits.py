"""How long the main control waits for the answers of other nodes."""

from __future__ import annotations

from dataclasses import dataclass

from gpr20_common.mid.checks import number_between
from gpr20_survey.trace.ms2026c import sweep_duration_s
from gpr20_survey.trace.sweep_settings import SweepSettings

# The driver takes sweeps when it sets up the analyzer, to learn how long one takes.
SWEEPS_OF_SETUP = 24
# What is assumed of an analyzer whose IF bandwidth is left as it is: still enough for one sweep at
# the narrowest of an MS2026C, 10 Hz.
UNKNOWN_IF_BANDWIDTH_HZ = 100.0


@dataclass(frozen=True)
class TimeLimits:
    """How long the main control waits for the answers of other nodes.

    Attributes:
        analyzer_limit_s: For an answer of the VNA driver [s].
        height_limit_s: For an answer of the height sensor [s].
        storage_limit_s: For an answer of the storage [s].
    """

    analyzer_limit_s: float = 90.0
    height_limit_s: float = 10.0
    storage_limit_s: float = 90.0

    def __post_init__(self) -> None:
        for name in ("analyzer_limit_s", "height_limit_s", "storage_limit_s"):
            number_between(name, getattr(self, name), 0.1, 3600.0, "s")

    def analyzer_setup_limit_s(self, settings: SweepSettings) -> float:
        """Return how long to wait until the analyzer is set up for these settings [s]."""
        sweep_s = sweep_duration_s(settings, unknown_if_bandwidth_hz=UNKNOWN_IF_BANDWIDTH_HZ)
        return self.analyzer_limit_s + SWEEPS_OF_SETUP * sweep_s
