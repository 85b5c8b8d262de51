"""The faults of the simulated robot itself; `mid.faults` switches those that it simulates."""

from __future__ import annotations

from gpr20_common.message import Fault, Message, Severity

FAULTS_SET = Fault(
    "simulator.faults_set",
    Message("When the test is over, end the fault with simulator/set_fault."),
    Severity.WARNING,
)
NETWORK_LOST = Fault("simulator.network_lost", Message("Launch the simulated robot again."))
NO_CAPTURE_FOLDER = Fault(
    "simulator.no_capture_folder", Message("Give another folder with capture_dir:=.")
)
WRONG_SCENE = Fault(
    "simulator.wrong_scene",
    Message("Correct the scene, as the message says, and launch the robot again."),
)
UNKNOWN_FAULT = Fault(
    "simulator.unknown_fault",
    Message("Give a device, a fault and a count that the simulated robot has."),
)
UNKNOWN_MEDIUM = Fault(
    "simulator.unknown_medium", Message("Launch the robot with a medium that the message names.")
)
# Its file is in memory, so a full data disk has nothing to do with it.
NO_STATE = Fault(
    "simulator.no_state",
    Message(
        "End every launch of a simulated robot, remove the file that the message names, and launch "
        "the robot again."
    ),
)
PORT_TAKEN = Fault("simulator.port_taken", Message("Free the port, or choose another one."))
VNA_NOT_STARTED = Fault(
    "simulator.vna_not_started", Message("Check that the simulator is running.")
)
