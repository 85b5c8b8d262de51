"""What a launch asks for, and the configuration that its nodes get."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Tuple

from gpr20_common.errors import ConfigurationError, Gpr20Error
from gpr20_common.low.data_folder import DEFAULT_FOLDER
from gpr20_common.message import Message, verbatim
from gpr20_launch.faults import LaunchRefusedError
from gpr20_launch.mid.robot_files import AXIS_SECTIONS, ROBOT, SERVER, Reading, Sections
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_simulator.mid.world.scene import read_scene
from gpr20_survey.errors import ProcessingError
from gpr20_survey.folder.data_folder import DataFolder
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C

SIMULATED, REAL = "simulated", "gpr20"
ALLOWED = {"robot": (SIMULATED, REAL), "full_screen": ("auto", "true", "false")}
LOOPBACK = "127.0.0.1"
# The simulated robot stores no rotation; that of the real one outlives the power.
ROTATION_FILE = "~/.gpr20/z_axis_steps"
# What describes another analyzer.
_OF_ANALYZER = ("analyzer", "analyzer_options", "maker", "model", "accepted_calibrations")
_SERVER_NODES = (
    *("vna_acquisition", "vna_processing", "imaging", "main_control", "visualization", "web"),
)


@dataclass(frozen=True)
class LaunchRequest:
    """The arguments of a launch.

    Attributes:
        part: robot, server, or survey for both.
        robot: simulated or gpr20.
        config: Folder of the configuration; empty: the default one, if it exists.
        data: Folder of the surveys; empty: as configured.
        simulator: Parameters of the simulated robot.
        full_screen: Whether the window covers the screen: auto, true or false.
    """

    part: str
    robot: str
    config: str
    data: str
    simulator: SimulatorParameters
    full_screen: str = "auto"

    def __post_init__(self) -> None:
        for name, allowed in ALLOWED.items():
            value = getattr(self, name)
            if value not in allowed:
                text = f"unknown {name}:={value}; it must be one of {', '.join(allowed)}"
                raise LaunchRefusedError(verbatim(text))
        if self.robot == REAL and self.simulator.time_scale != 1.0:
            text = f"time_scale:={self.simulator.time_scale:g} is for the simulated robot; leave it"
            raise LaunchRefusedError(verbatim(f"{text} out with robot:={REAL}"))

    @property
    def nodes(self) -> Tuple[str, ...]:
        """Names of the nodes that it starts, relative to the robot's namespace."""
        simulator = ("simulator",) if self.robot == SIMULATED else ()
        axes = (f"{section}/axis_driver" for section in AXIS_SECTIONS.values())
        on_robot = () if self.part == SERVER else (*axes, "height_sensor", *simulator)
        return (*on_robot, *(() if self.part == ROBOT else _SERVER_NODES))

    @property
    def folder(self) -> Path:
        """Folder of the configuration.

        Raises:
            ConfigurationError: The folder that was given is none.
        """
        folder = Path(self.config or DEFAULT_FOLDER).expanduser().absolute()
        if self.config and not folder.is_dir():
            text = f"{folder} (config:=) is no folder; create it with its files: "
            text += f"rosrun gpr20_launch robot_config create {folder}"
            raise ConfigurationError(verbatim(text))
        return folder

    def sections(self, reading: Reading) -> Sections:
        """Return the configuration of the nodes, of one with which nothing is wrong.

        Raises:
            LaunchRefusedError: The scene cannot be read, or the data folder not be written.
        """
        sections = {name: dict(own) for name, own in reading.sections.items()}
        if self.robot == SIMULATED:
            self._simulate(sections)
        elif not reading.record("z_axis").finds_zero:
            rotation_file = str(Path(ROTATION_FILE).expanduser())
            sections["z_axis"].setdefault("memory_file", rotation_file)
        if self.part != ROBOT:
            folder = str(self._data_folder(reading))
            sections["storage"]["data"] = folder
            sections["imaging"] = {"data": folder}
        return sections

    def _simulate(self, sections: Sections) -> None:
        scene = Path(self.simulator.scene).expanduser().absolute()
        try:
            read_scene(str(scene))
        except Gpr20Error as error:
            raise LaunchRefusedError(error.message) from error
        sections["simulator"] = {**asdict(self.simulator), "scene": str(scene)}
        # Its carriage has motors with pins.
        for section in AXIS_SECTIONS.values():
            for key in ("controller", "controller_options"):
                sections[section].pop(key, None)
        # The instrument of the configuration is a real one, perhaps of another kind.
        analyzer = sections["vna_acquisition"]
        if analyzer.get("analyzer", MS2026C) != MS2026C:
            for key in _OF_ANALYZER:
                analyzer.pop(key, None)
        analyzer["address"] = LOOPBACK

    def _data_folder(self, reading: Reading) -> Path:
        storage = reading.record("storage")
        use = replace(storage, data=self.data.strip() or storage.data).data_folder_use()
        try:
            DataFolder(use).check()
        except ProcessingError as error:
            reason = Message("no survey can be stored: {reason}", reason=error.message)
            raise LaunchRefusedError(reason) from error
        return use.path
