"""The sentences that go with every list of candidates."""

from gpr20_common.message import Message

NO_CLEARANCE = Message(
    "This is a list of candidates, no clearance: ground without a candidate is not free of mines."
)
SIMULATED = Message("SIMULATED: these are no measurements of real ground.")
