"""What the random tests of a run draw from.

The same in each run, so that a failed test is the fault of a change. `scripts/test.sh random`
draws something else in each run; GPR20_SEED repeats one of them.
"""

from __future__ import annotations

import os

SEED = os.environ.get("GPR20_SEED", "1")
