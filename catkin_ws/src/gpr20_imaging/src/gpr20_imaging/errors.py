"""What the imaging node refuses, and what fails in it."""

from __future__ import annotations

from gpr20_common.errors import Gpr20Error
from gpr20_imaging import faults


class ImagingError(Gpr20Error):
    """A request to the imaging node was refused or failed."""

    fault = faults.OTHER_COMPUTER
