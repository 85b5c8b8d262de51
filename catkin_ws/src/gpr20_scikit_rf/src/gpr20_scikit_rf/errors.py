"""What can go wrong with an analyzer of another maker, beside what can with any."""

from __future__ import annotations

from gpr20_common.faults import CONFIGURATION
from gpr20_vna_acquisition.errors import VnaError


class VnaLibraryError(VnaError, ImportError):
    """A library that this kind of analyzer needs is not installed, or too old."""

    fault = CONFIGURATION
