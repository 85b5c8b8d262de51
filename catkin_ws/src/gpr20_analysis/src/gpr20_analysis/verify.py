"""The command gpr20-verify: `gpr20 verify` under the name it had first."""

from __future__ import annotations

import sys
from typing import List, Optional

from gpr20_analysis.commands import main as gpr20


def main(arguments: Optional[List[str]] = None) -> int:
    """Check the folder that is named; return the exit status."""
    return gpr20.main(["verify", *(sys.argv[1:] if arguments is None else arguments)])


if __name__ == "__main__":
    sys.exit(main())
