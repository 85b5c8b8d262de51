"""The sentence that goes with every list of candidates."""

from gpr20_common.message import Message

NO_CLEARANCE = Message(
    "This is a list of candidates, no clearance: ground without a candidate is not free of mines."
)
