"""What the simulated robot consists of and what is below it: the scene file.

Every key has a default but those that only the user can know (a target's place), so a
scene file says only what is special about it.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, field
from typing import Optional, Tuple

from gpr20_common.errors import InvalidValueError, os_reason
from gpr20_common.low.yaml_file import YamlFileError, read_yaml
from gpr20_common.message import Message
from gpr20_common.mid.codec import bounded, record_from
from gpr20_simulator.mid.faults import SceneError
from gpr20_survey.axes import Level
from gpr20_survey.plan.robot_description import SIMULATED_IDENTITY as SIMULATED

NOT_CALIBRATED = 0
ALL_PARAMETERS = 15


@dataclass(frozen=True)
class InstrumentScene:
    """The simulated network analyzer.

    Attributes:
        manufacturer: First field of its identity.
        model: Second field, options joined to it with "/".
        serial: Third field; contains SIMULATED.
        firmware: Fourth field.
        calibration_accuracy: 0 none, 1 high, 2 power changed, 3 temperature moved, 4 low.
        setting_delay_s: How long a setting takes to have an effect [s].
        calibrated_parameters: Which S-parameters are calibrated: the sum of S11 = 1, S12 = 2,
            S21 = 4 and S22 = 8.
        temperature_c: What it says of its temperature [degC], in quarters.
        late_memory_s: Fault LATE_MEMORY: how long after the end of a sweep the display has it [s].
        late_bit_s: Fault LATE_BIT: how long the bit stays set after a trigger [s].
        slow_point_s: Fault SLOW_POINTS: time of one frequency of a sweep [s].
        other_serial: Faults OTHER_SERIAL and SWAPPED: the serial number; contains SIMULATED.
    """

    manufacturer: str = "Anritsu"
    model: str = "MS2026C/2"
    serial: str = SIMULATED
    firmware: str = "1.23"
    calibration_accuracy: int = bounded(NOT_CALIBRATED, 4, 1)
    setting_delay_s: float = bounded(0.0, 10.0, 0.0)
    calibrated_parameters: int = bounded(0, ALL_PARAMETERS, ALL_PARAMETERS)
    temperature_c: float = bounded(-40.0, 100.0, 40.0)
    late_memory_s: float = bounded(0.0, 60.0, 0.2)
    late_bit_s: float = bounded(0.0, 60.0, 0.3)
    slow_point_s: float = bounded(0.0, 10.0, 2e-3)
    other_serial: str = f"{SIMULATED}-2"

    def __post_init__(self) -> None:
        for serial in (self.serial, self.other_serial):
            if SIMULATED not in serial:
                raise SceneError(
                    Message(
                        "the serial number of the simulated VNA is {serial}; it must contain "
                        "{marker}, so that its data are never taken for those of a real one",
                        serial=repr(serial),
                        marker=SIMULATED,
                    )
                )


class Shape(enum.Enum):
    """Shape of a buried target."""

    SPHERE = "sphere"
    DISC = "disc"
    LINE = "line"


PLACES = (-5000.0, 5000.0)
"""Within which all of the robot and of the ground lies [mm, or deg]."""


@dataclass(frozen=True)
class Soil:
    """The ground as a uniform half space.

    Attributes:
        relative_permittivity: Real part, relative to vacuum.
        loss_tangent: Imaginary over real part of the permittivity.
    """

    relative_permittivity: float = bounded(1.0, 81.0, 4.0)
    loss_tangent: float = bounded(0.0, 1.0, 0.01)


@dataclass(frozen=True)
class Surface:
    """The surface: a plane at height 0 with a slope and a wave on it.

    Attributes:
        slope_x: Rise per distance along X [m/m].
        slope_y: Rise per distance along Y [m/m].
        wave_amplitude_m: Amplitude of the undulation [m].
        wave_length_m: Distance between two crests, along X and along Y [m].
    """

    slope_x: float = bounded(-0.2, 0.2, 0.0)
    slope_y: float = bounded(-0.2, 0.2, 0.0)
    wave_amplitude_m: float = bounded(0.0, 0.1, 0.0)
    wave_length_m: float = bounded(0.05, 100.0, 0.5)


@dataclass(frozen=True)
class Antennas:
    """The antenna pair.

    Attributes:
        height_m: Height of the antennas above the plane z = 0 [m].
        separation_m: Distance between the two antennas, along their rotation [m].
        coupling_level_db: Magnitude of the direct transmission between them [dB].
        coupling_delay_s: Delay of the direct transmission, without `delay_s` [s].
        surface_gain_db: Magnitude of the echo of a perfect mirror at 0.1 m of path [dB].
        delay_s: Delay of cables and antennas, which every path has in addition [s].
    """

    height_m: float = bounded(0.05, 0.6, 0.20)
    separation_m: float = bounded(0.0, 0.5, 0.0)
    coupling_level_db: float = bounded(-200.0, -3.0, -35.0)
    coupling_delay_s: float = bounded(0.0, 100e-9, 0.4e-9)
    surface_gain_db: float = bounded(-200.0, -3.0, -14.0)
    delay_s: float = bounded(0.0, 100e-9, 0.0)


@dataclass(frozen=True)
class Target:
    """Something buried.

    Attributes:
        name: For people.
        shape: How it reflects: a sphere from its surface towards the antennas, a disc
            and a line from all of their upper side.
        x_mm: Centre along X [mm].
        y_mm: Centre along Y [mm].
        depth_m: Depth of its upper side below the plane z = 0 [m].
        size_m: Diameter of a sphere or disc, length of a line [m].
        direction_deg: Direction of a line, from X towards Y [deg].
        x_pol_strength: Echo at rotation 0 deg, as a fraction of a field that has
            travelled 0.1 m each way.
        y_pol_strength: The same at rotation 90 deg.
    """

    name: str
    shape: Shape
    x_mm: float = bounded(*PLACES)
    y_mm: float = bounded(*PLACES)
    depth_m: float = bounded(0.001, 2.0)
    size_m: float = bounded(0.001, 0.5, 0.05)
    direction_deg: float = bounded(-180.0, 180.0, 0.0)
    x_pol_strength: float = bounded(-0.5, 0.5, 0.05)
    y_pol_strength: float = bounded(-0.5, 0.5, 0.05)


@dataclass(frozen=True)
class Noise:
    """Receiver noise of the analyzer.

    Attributes:
        level_db: Root mean square of the complex noise on S21 [dB].
        seed: Start of the random numbers; equal seeds give equal noise.
    """

    level_db: float = bounded(-300.0, -10.0, -90.0)
    seed: int = bounded(0, 2**31 - 1, 20)


@dataclass(frozen=True)
class AxisMechanics:
    """What one motor moves; places in [mm], or [deg] for the rotary axis.

    Attributes:
        size_per_step: Travel of one motor step [mm or deg].
        start: Where the axis is when the robot is switched on [mm or deg].
        endstop: The endstop is pressed at this place and below; None: there is none.
        lower_stop: The axis cannot go lower [mm or deg].
        upper_stop: The axis cannot go higher [mm or deg].
        endstop_active: Level to which the endstop connects its pin while it is pressed.
        direction_inverted: Whether the direction pin is low for increasing coordinates.
        enable_pin: Enable pin of the motor driver [BOARD number]; None: it is always enabled.
        enable_active: Level at which the motor driver is enabled.
    """

    size_per_step: float = bounded(1e-4, 45.0, 0.01)
    start: float = bounded(*PLACES, 8.0)
    endstop: Optional[float] = bounded(*PLACES, -1.0)
    lower_stop: float = bounded(*PLACES, -3.0)
    upper_stop: float = bounded(*PLACES, 653.0)
    endstop_active: Level = Level.LOW
    direction_inverted: bool = False
    enable_pin: Optional[int] = None
    enable_active: Level = Level.LOW


@dataclass(frozen=True)
class YAxisMechanics(AxisMechanics):
    """The same, with what differs on the Y axis."""

    start: float = bounded(*PLACES, 6.0)
    upper_stop: float = bounded(*PLACES, 803.0)


@dataclass(frozen=True)
class ZAxisMechanics(AxisMechanics):
    """The same on the rotary axis: neither endstop nor stops; its cable ends it after two turns."""

    size_per_step: float = bounded(1e-4, 45.0, 1.8)
    start: float = bounded(*PLACES, 0.0)
    endstop: Optional[float] = bounded(*PLACES, None)
    lower_stop: float = bounded(*PLACES, -720.0)
    upper_stop: float = bounded(*PLACES, 720.0)


X_AXIS, Y_AXIS, Z_AXIS = AxisMechanics(), YAxisMechanics(), ZAxisMechanics()


@dataclass(frozen=True)
class RobotMechanics:
    """The three axes of the carriage."""

    x: AxisMechanics = X_AXIS
    y: YAxisMechanics = Y_AXIS
    z: ZAxisMechanics = Z_AXIS


@dataclass(frozen=True)
class Adc:
    """The analog-to-digital converter and the height sensor before it.

    Attributes:
        reference_voltage_v: Voltage of the highest code [V].
        noise_v: Standard deviation of the sensor's noise [V].
        seed: Start of the random numbers.
    """

    reference_voltage_v: float = bounded(1.0, 6.0, 3.3)
    noise_v: float = bounded(0.0, 1.0, 0.003)
    seed: int = bounded(0, 2**31 - 1, 40)


@dataclass(frozen=True)
class Scene:
    """All of a scene file."""

    name: str = "empty"
    soil: Soil = field(default_factory=Soil)
    surface: Surface = field(default_factory=Surface)
    antennas: Antennas = field(default_factory=Antennas)
    targets: Tuple[Target, ...] = ()
    noise: Noise = field(default_factory=Noise)
    robot: RobotMechanics = field(default_factory=RobotMechanics)
    adc: Adc = field(default_factory=Adc)
    instrument: InstrumentScene = field(default_factory=InstrumentScene)

    def __post_init__(self) -> None:
        """Refuse combinations that the ground cannot be computed for."""
        _check_axis("robot.x", self.robot.x)
        _check_axis("robot.y", self.robot.y)
        _check_axis("robot.z", self.robot.z)
        self._check_surface()

    def _check_surface(self) -> None:
        highest_m = self._surface_extent_m()
        if highest_m > self.antennas.height_m - 0.02:
            raise SceneError(
                Message(
                    "the surface rises up to {highest_m:.3g} m within the axes and the antennas "
                    "are at {antennas_m:g} m; leave at least 0.02 m between them",
                    highest_m=highest_m,
                    antennas_m=self.antennas.height_m,
                )
            )
        for target in self.targets:
            if target.depth_m <= highest_m:
                raise SceneError(
                    Message(
                        "target '{target}' is {depth_m:g} m deep, but the surface dips up to "
                        "{dip_m:.3g} m; bury it deeper than that",
                        target=target.name,
                        depth_m=target.depth_m,
                        dip_m=highest_m,
                    )
                )

    def _surface_extent_m(self) -> float:
        reach_x_m = max(abs(self.robot.x.lower_stop), self.robot.x.upper_stop) / 1000.0
        reach_y_m = max(abs(self.robot.y.lower_stop), self.robot.y.upper_stop) / 1000.0
        return (
            abs(self.surface.slope_x) * reach_x_m
            + abs(self.surface.slope_y) * reach_y_m
            + self.surface.wave_amplitude_m
        )


def _check_axis(place: str, axis: AxisMechanics) -> None:
    for name, value in (("start", axis.start), ("endstop", axis.endstop)):
        if value is not None and not axis.lower_stop <= value <= axis.upper_stop:
            raise SceneError(
                Message(
                    "{place} is {value:g}; it must lie between the hard stops {lower:g} and "
                    "{upper:g}",
                    place=f"{place}.{name}",
                    value=value,
                    lower=axis.lower_stop,
                    upper=axis.upper_stop,
                )
            )


def read_scene(path: str) -> Scene:
    """Read a scene file.

    Raises:
        SceneError: The file cannot be read, or holds something that is not allowed.
    """
    try:
        values = read_yaml(path)
    except (OSError, YamlFileError) as error:
        reason = os_reason(error) if isinstance(error, OSError) else error.message
        raise SceneError(
            Message(
                "the scene file {path} cannot be read: {reason}", path=path, reason=reason
            ).reporting_only(SceneError.fault)
        ) from error
    try:
        return record_from(Scene, values, "scene")
    except InvalidValueError as error:
        raise SceneError(
            Message(
                "the scene file {path}: {reason}", path=path, reason=error.message
            ).reporting_only(SceneError.fault)
        ) from error


def amplitude(level_db: float) -> float:
    """Return the magnitude of a level in decibels."""
    return math.pow(10.0, level_db / 20.0)
