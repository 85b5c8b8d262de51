"""What chrony says of the clock of this computer."""

from __future__ import annotations

import shutil
import subprocess
from typing import Optional, Tuple

PROGRAM = "chronyc"
LIMIT_S = 1.0
# Columns of `chronyc -c tracking`: the offset of the clock [s], and the leap status.
OFFSET, LEAP = 4, 13
UNSYNCHRONIZED = "Not synchronised"


def tracking(program: str = PROGRAM) -> Optional[Tuple[bool, float]]:
    """Return whether the clock follows a source, and its offset [s]; None without chrony.

    Raises:
        OSError: chrony does not run or did not answer in time.
        ValueError: Its answer was not understood.
    """
    path = shutil.which(program)
    if path is None:
        return None
    try:
        answer = subprocess.run(
            [path, "-c", "tracking"], capture_output=True, timeout=LIMIT_S, check=True
        )
    except subprocess.SubprocessError as error:
        raise OSError(str(error)) from error
    fields = answer.stdout.decode(errors="replace").strip().split(",")
    if len(fields) <= LEAP:
        raise ValueError(f"chronyc answered {answer.stdout[:80]!r}")
    return fields[LEAP] != UNSYNCHRONIZED, float(fields[OFFSET])
