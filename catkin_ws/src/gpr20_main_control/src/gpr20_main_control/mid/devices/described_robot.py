"""What the robot is, as its nodes describe themselves, and when that becomes known."""

from __future__ import annotations

import threading
from dataclasses import asdict, dataclass
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded
from gpr20_common.mid.node_facts import software_difference
from gpr20_main_control import faults
from gpr20_main_control.errors import DeviceError
from gpr20_survey.faults import WRONG_VNA
from gpr20_survey.plan.annotation import Site
from gpr20_survey.plan.robot_description import (
    ANALYZER,
    HEIGHT_SENSOR,
    STORAGE,
    NodeDescription,
    RobotConfig,
    is_simulated_identity,
    robot_config,
)
from gpr20_survey.trace.ms2026c import sweep_duration_s
from gpr20_survey.trace.sweep_settings import SweepSettings

# Entries of survey.json that hold the configuration of a node.
RECORDED = {"height": HEIGHT_SENSOR, "analyzer": ANALYZER, "storage": STORAGE}
# The driver takes sweeps when it sets up the analyzer, to learn how long one takes.
SWEEPS_OF_SETUP = 24
# What is assumed of an analyzer whose IF bandwidth is left as it is: still enough for one sweep at
# the narrowest of an MS2026C, 10 Hz.
UNKNOWN_IF_BANDWIDTH_HZ = 100.0


@dataclass(frozen=True)
class TimeLimits:
    """How long the main control waits for the answers of other nodes.

    Attributes:
        analyzer_limit_s: For an answer of the VNA driver [s].
        height_limit_s: For an answer of the height sensor [s].
        storage_limit_s: For an answer of the storage [s].
    """

    analyzer_limit_s: float = bounded(0.1, 3600.0, 90.0)
    height_limit_s: float = bounded(0.1, 3600.0, 10.0)
    storage_limit_s: float = bounded(0.1, 3600.0, 90.0)

    def analyzer_setup_limit_s(self, settings: SweepSettings) -> float:
        """Return how long to wait until the analyzer is set up for these settings [s]."""
        sweep_s = sweep_duration_s(settings, unknown_if_bandwidth_hz=UNKNOWN_IF_BANDWIDTH_HZ)
        return self.analyzer_limit_s + SWEEPS_OF_SETUP * sweep_s


class DescribedRobot:
    """Holds the description of each node; every method may be called from any thread.

    Attributes:
        site: The robot's name and place.
        limits: How long the main control waits for the nodes.
    """

    def __init__(
        self, site: Site, limits: TimeLimits, on_change: Callable[[DescribedRobot], None]
    ) -> None:
        """Begin with no description.

        Args:
            site: The robot's name and place.
            limits: How long the main control waits for the nodes, to be recorded.
            on_change: Called after each new description.
        """
        self.site = site
        self.limits = limits
        self._on_change = on_change
        self._described = threading.Condition()
        self._nodes: Dict[str, NodeDescription] = {}
        self._config: Optional[RobotConfig] = None

    @property
    def nodes(self) -> Mapping[str, NodeDescription]:
        """The descriptions received so far, by their nodes."""
        with self._described:
            return dict(self._nodes)

    def note(self, description: NodeDescription) -> None:
        """Note what a node is now."""
        with self._described:
            self._nodes[description.node] = description
            self._config = None
            self._described.notify_all()
        self._on_change(self)

    def config(self, wait_s: float = 0.0) -> RobotConfig:
        """Return what is fixed for the robot.

        Args:
            wait_s: How long to wait for the descriptions of nodes that are starting [s].

        Raises:
            InvalidValueError: A node has not described itself, or they disagree.
        """
        with self._described:
            # Asked for at every sample, and seldom another one.
            if self._config is None:
                self._described.wait_for(lambda: self.problem() is None, wait_s)
                self._config = robot_config(self._nodes)
            return self._config

    def analyzer_address(self) -> str:
        """Return the address of the analyzer in the robot's configuration.

        Raises:
            InvalidValueError: A node has not described itself, or they disagree.
        """
        self.config()
        return str(self.nodes[ANALYZER].configuration.get("address", ""))

    def problem(self) -> Optional[Message]:
        """Return why no survey can be measured; None if nothing is wrong."""
        try:
            robot_config(self.nodes)
        except InvalidValueError as error:
            return error.message
        return None

    def software_difference(self) -> Optional[Message]:
        """Return which nodes run which software; None if all run the same."""
        return software_difference({name: one.software for name, one in self.nodes.items()})

    def check(self, config: RobotConfig) -> None:
        """Return if the robot is still the one with which a survey began.

        Raises:
            DeviceError: It is not, or nobody can say.
        """
        try:
            present = self.config()
        except InvalidValueError as error:
            raise DeviceError(error.message) from error
        if present != config:
            raise DeviceError(
                Message(
                    "a part of the robot was restarted with another configuration than the survey "
                    "began with; end the launch, start it with the former configuration and "
                    "resume the survey"
                ),
                fault=faults.CONFIGURATION_CHANGED,
            )

    def check_identity(self, identity: str, config: RobotConfig) -> None:
        """Return if an analyzer is simulated where the robot is, and real where it is real.

        Raises:
            DeviceError: It is not.
        """
        if is_simulated_identity(identity) and not config.simulated:
            raise DeviceError(
                Message(
                    "the VNA is a simulated one ({identity}), but the robot is real; check the "
                    "address of the VNA",
                    identity=identity,
                ),
                fault=WRONG_VNA,
            )
        if config.simulated and not is_simulated_identity(identity):
            raise DeviceError(
                Message(
                    "the VNA is a real one ({identity}), but the robot is simulated; use the "
                    "address 127.0.0.1, or launch with robot:=gpr20",
                    identity=identity,
                ),
                fault=WRONG_VNA,
            )

    def recorded(self) -> Dict[str, Any]:
        """Return what the log records about the nodes and the site."""
        nodes = self.nodes
        present = {key: nodes[name] for key, name in RECORDED.items() if name in nodes}
        return {
            "nodes": [
                {**asdict(one.hardware), "hardware": one.hardware.name, "name": name}
                for name, one in sorted(nodes.items())
                if one.hardware.name
            ],
            **{key: dict(one.configuration) for key, one in present.items()},
            "time_limits": asdict(self.limits),
            "site": asdict(self.site),
        }
