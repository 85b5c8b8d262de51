"""How long the main control waits for the answers of other nodes."""

from __future__ import annotations

from dataclasses import dataclass

from gpr20_common.mid.checks import number_between

# The driver takes sweeps when it sets up the analyzer, to learn how long one takes. With a narrow
# IF bandwidth and averages that is minutes; a driver that is dead is noticed otherwise [s].
ANALYZER_SETUP_LIMIT_S = 3600.0


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
