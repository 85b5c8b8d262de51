"""The parameters of the simulated robot, common to its processes."""

from __future__ import annotations

from dataclasses import dataclass

from gpr20_common.mid.checks import number_between

LONGEST_POINT_S = 10.0
MAX_PORT = 65535


@dataclass(frozen=True)
class SimulatorParameters:
    """The simulated robot.

    Attributes:
        scene: File of the ground and the machine.
        time_scale: How many times faster than the real robot it runs.
        seconds_per_point: Time that one frequency of a sweep takes [s].
        port: TCP port of the VXI-11 core channel; 0: any free one.
        portmapper: Whether to answer on port 111 too, where VXI-11 clients look first.
        medium: `scene`, or `position_probe` for tests.
        capture_dir: Folder for the exact bytes of each data reply; empty: none.
    """

    scene: str = ""
    time_scale: float = 1.0
    seconds_per_point: float = 350e-6
    port: int = 0
    portmapper: bool = False
    medium: str = "scene"
    capture_dir: str = ""

    def __post_init__(self) -> None:
        number_between("time_scale", self.time_scale, 1e-6, 1e6)
        number_between("seconds_per_point", self.seconds_per_point, 0.0, LONGEST_POINT_S, "s")
        number_between("port", self.port, 0, MAX_PORT)
