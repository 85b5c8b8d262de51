"""The nodes of a launch, and the configuration that they get."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Tuple

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_launch.faults import LaunchRefusedError
from gpr20_launch.mid.robot_files import AXIS_SECTIONS, ROBOT, SERVER, Reading, Sections, Use
from gpr20_simulator.mid.simulator_parameters import SimulatorParameters
from gpr20_simulator.mid.world.scene import read_scene
from gpr20_survey.errors import ProcessingError
from gpr20_survey.folder.data_folder import DataFolder
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C

LOOPBACK = "127.0.0.1"
# The simulated robot stores no rotation; that of the real one outlives the power.
ROTATION_FILE = "~/.gpr20/z_axis_steps"
# What describes another analyzer.
_OF_ANALYZER = ("analyzer", "analyzer_options", "maker", "model", "accepted_calibrations")
_SERVER_NODES = (
    *("vna_acquisition", "vna_processing", "imaging", "main_control", "visualization", "web"),
)


def nodes_of(use: Use) -> Tuple[str, ...]:
    """Return the names of the nodes that are started, relative to the robot's namespace."""
    axes = (f"{section}/axis_driver" for section in AXIS_SECTIONS.values())
    on_robot = (*axes, "height_sensor", *(() if use.real else ("simulator",)))
    on_server = () if use.part == ROBOT else _SERVER_NODES
    return on_server if use.part == SERVER else (*on_robot, *on_server)


def sections_of(reading: Reading, use: Use, simulator: SimulatorParameters) -> Sections:
    """Return what the nodes get of a configuration with which nothing is wrong.

    Raises:
        LaunchRefusedError: The scene cannot be read, or the data folder not be written.
    """
    sections = {name: dict(own) for name, own in reading.sections.items()}
    if not use.real:
        _simulate(sections, simulator)
    elif not reading.record("z_axis").finds_zero:
        sections["z_axis"].setdefault("memory_file", str(Path(ROTATION_FILE).expanduser()))
    if use.part != ROBOT:
        storage = reading.record("storage")
        folder = replace(storage, data=use.data.strip() or storage.data).data_folder_use()
        try:
            DataFolder(folder).check()
        except ProcessingError as error:
            reason = Message("no survey can be stored: {reason}", reason=error.message)
            raise LaunchRefusedError(reason) from error
        sections["storage"]["data"] = str(folder.path)
        sections["imaging"] = {"data": str(folder.path)}
    return sections


def _simulate(sections: Sections, simulator: SimulatorParameters) -> None:
    scene = str(Path(simulator.scene).expanduser().absolute())
    try:
        read_scene(scene)
    except Gpr20Error as error:
        raise LaunchRefusedError(error.message) from error
    sections["simulator"] = {**asdict(simulator), "scene": scene}
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
