"""The command gpr20-verify, the same as `gpr20 verify`."""

from __future__ import annotations

import sys
from typing import List, Optional

from gpr20_analysis.commands import main as gpr20


def main(arguments: Optional[List[str]] = None) -> int:
    """Check a survey's folder; return the exit status."""
    return gpr20.main(["verify", *(sys.argv[1:] if arguments is None else arguments)])


if __name__ == "__main__":
    sys.exit(main())
