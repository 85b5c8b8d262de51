"""What an axis answers when it stopped because it had no contact with its client."""

from __future__ import annotations

from gpr20_common.message import Message

# Compared by the main control: nobody asked for this stop, so the survey may continue by itself.
CONTROL_SILENT = Message("the axis stopped because it had no contact with the main control")
