"""Random requests to the page at a distance: foreign exceptions, and what was done without right.

Usage: scripts/bench.sh web_fuzz [--requests 100000] [--seed SEED]

It is the test of the suite (gpr20_web/test/unit/test_fuzz.py) with more requests: a fifth are bytes
that are, or once were, a request; the others go to the table of routes with known and unknown
fields of odd values, from persons of each role. It ends at the first request that does what it may
not, that is answered by 500, or that leaves an exception.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from pathlib import Path

TEST = "catkin_ws/src/gpr20_web/test/unit/test_fuzz.py"


def main() -> int:
    """Run the test; return its exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--requests", type=int, default=100_000)
    parser.add_argument("--seed", default="1")
    given = parser.parse_args()
    numbers = {"GPR20_FUZZ_REQUESTS": str(given.requests), "GPR20_SEED": given.seed}
    command = [sys.executable, "-m", "pytest", "-q", "-s", "--timeout", "0", TEST]
    root = Path(__file__).resolve().parent.parent
    return subprocess.run(command, cwd=root, env={**os.environ, **numbers}, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
