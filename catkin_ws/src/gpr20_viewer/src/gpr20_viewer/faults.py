"""The faults that the viewer can report."""

from __future__ import annotations

from gpr20_common.message import Fault, Message

NO_SCREEN = Fault("analysis.no_screen", Message("Run the command on a computer with a desktop."))
PICK = Fault("viewer.pick", Message("Correct the pick, or choose another place."))
PICKS_FILE = Fault("viewer.picks_file", Message("Choose another file for the picks with --picks."))
PICKS_CHANGED = Fault(
    "viewer.picks_changed", Message("Export the picks now, then open the survey again.")
)
