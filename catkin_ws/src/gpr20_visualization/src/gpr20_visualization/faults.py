"""The faults of the visualization."""

from __future__ import annotations

from gpr20_common import remedies
from gpr20_common.message import Fault

WRONG_DESCRIPTION = Fault("visualization.wrong_description", remedies.CHECK_CONFIGURATION)
