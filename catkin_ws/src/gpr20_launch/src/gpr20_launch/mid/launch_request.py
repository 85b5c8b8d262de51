"""What a launch asks for, and the configuration that its nodes get."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Dict, Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.data_folder import DEFAULT_FOLDER
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_launch.errors import ConfigurationError, LaunchRefusedError
from gpr20_launch.mid.robot_files import Sections, read_configuration
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_simulator.mid.world.scene import read_scene
from gpr20_survey.axes.axis_id import AxisId
from gpr20_survey.axes.axis_parameters import AxisParameters
from gpr20_survey.errors import ProcessingError
from gpr20_survey.folder.data_folder import DataFolder
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

SIMULATED, REAL = "simulated", "gpr20"
ROBOT, SERVER, SURVEY = "robot", "server", "survey"
FULL_SCREEN = ("auto", "true", "false")
LOOPBACK = "127.0.0.1"
# The simulated robot stores no rotation; that of the real one outlives the power.
ROTATION_FILE = "~/.gpr20/z_axis_steps"
_AXES = tuple(f"{axis_id.value}_axis/axis_driver" for axis_id in AxisId)
_OF_ANALYZER = ("maker", "model", "accepted_calibrations")
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
    full_screen: str = FULL_SCREEN[0]

    def __post_init__(self) -> None:
        for name, allowed in (("robot", (SIMULATED, REAL)), ("full_screen", FULL_SCREEN)):
            value = getattr(self, name)
            if value not in allowed:
                values = {"name": name, "value": value, "allowed": ", ".join(allowed)}
                text = Message("unknown {name}:={value}; it must be one of {allowed}", **values)
                raise LaunchRefusedError(text)
        if self.robot == REAL and self.simulator.time_scale != 1.0:
            raise LaunchRefusedError(
                Message(
                    "time_scale:={time_scale:g} is for the simulated robot; leave it out with "
                    "robot:={real}",
                    time_scale=self.simulator.time_scale,
                    real=REAL,
                )
            )

    @property
    def nodes(self) -> Tuple[str, ...]:
        """Names of the nodes that it starts, relative to the robot's namespace."""
        simulator = ("simulator",) if self.robot == SIMULATED else ()
        on_robot = (*_AXES, "height_sensor", *simulator)
        server = () if self.part == ROBOT else _SERVER_NODES
        return (*(() if self.part == SERVER else on_robot), *server)

    def sections(self, built_axes: Path) -> Sections:
        """Return the configuration of the nodes, checked.

        Raises:
            ConfigurationError: A file of the configuration is wrong.
            LaunchRefusedError: The scene cannot be read, or the data folder not be written.
        """
        sections = read_configuration(self.folder, built_axes)
        if self.robot == SIMULATED:
            self._simulate(sections)
        elif not record_from(AxisParameters, sections["z_axis"], "z_axis").finds_zero:
            rotation_file = str(Path(ROTATION_FILE).expanduser())
            sections["z_axis"].setdefault("memory_file", rotation_file)
        if self.part in (SERVER, SURVEY):
            sections["storage"]["data"] = str(self._data_folder(sections))
            sections["imaging"] = {"data": sections["storage"]["data"]}
        return sections

    @property
    def folder(self) -> Path:
        """Folder of the configuration.

        Raises:
            ConfigurationError: The folder that was given is none.
        """
        folder = Path(self.config or DEFAULT_FOLDER).expanduser().absolute()
        if self.config and not folder.is_dir():
            raise ConfigurationError(
                Message(
                    "{folder} (config:=) is no folder; create it with its files: "
                    "rosrun gpr20_launch robot_config create {folder}",
                    folder=folder,
                )
            )
        return folder

    def _simulate(self, sections: Sections) -> None:
        simulator: Dict[str, object] = asdict(self.simulator)
        scene = Path(self.simulator.scene).expanduser().absolute()
        try:
            read_scene(str(scene))
        except Gpr20Error as error:
            raise LaunchRefusedError(error.message) from error
        sections["simulator"] = {**simulator, "scene": str(scene)}
        # Its carriage has motors with pins.
        for axis_id in AxisId:
            for key in ("controller", "controller_options"):
                sections[f"{axis_id.value}_axis"].pop(key, None)
        # The instrument of the configuration is a real one, perhaps of another kind.
        analyzer = sections["vna_acquisition"]
        if analyzer.get("analyzer", MS2026C) != MS2026C:
            for key in ("analyzer", "analyzer_options", *_OF_ANALYZER):
                analyzer.pop(key, None)
        analyzer["address"] = LOOPBACK

    def _data_folder(self, sections: Sections) -> Path:
        use = storage_parameters(sections, self.data).data_folder_use()
        try:
            DataFolder(use).check()
        except ProcessingError as error:
            raise LaunchRefusedError(
                Message("no survey can be stored: {reason}", reason=error.message)
            ) from error
        return use.path


def storage_parameters(sections: Sections, data: str) -> ProcessingParameters:
    """Return the parameters of the storage; `data` replaces the configured folder unless empty.

    Raises:
        InvalidValueError: A value is not allowed.
    """
    given = {**sections["storage"], **({"data": data} if data.strip() else {})}
    return record_from(ProcessingParameters, given, "storage")
