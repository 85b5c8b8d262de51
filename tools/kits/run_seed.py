"""What the random tests of a run draw from, and how much.

The same in each run, so that a failed test is the fault of a change. `scripts/test.sh random`
draws something else in each run; GPR20_SEED repeats one of them.
"""

from __future__ import annotations

import os

SEED = os.environ.get("GPR20_SEED", "1")
# Set by `scripts/test.sh release` and `scripts/test.sh random`.
LONG = bool(os.environ.get("GPR20_LONG"))


def draws(count: int) -> int:
    """Return how many inputs a random test draws: four times as many for a release.

    Args:
        count: How many it draws for a change.
    """
    return 4 * count if LONG else count
