"""The robot's links and joints from its URDF, and where each link is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Mapping, Tuple
from xml.etree import ElementTree

import numpy as np

from gpr20_common.errors import Gpr20Error
from gpr20_common.faults import CONFIGURATION
from gpr20_common.message import Message

Vector = Tuple[float, float, float]
Quaternion = Tuple[float, float, float, float]

MM_PER_M = 1000.0
Y_JOINT, X_JOINT, Z_JOINT = "y_axis_joint", "x_axis_joint", "z_axis_joint"
JOINTS = (Y_JOINT, X_JOINT, Z_JOINT)
PRISMATIC, REVOLUTE, FIXED = "prismatic", "revolute", "fixed"
TYPES = (PRISMATIC, REVOLUTE, FIXED)


class RobotModelError(Gpr20Error, ValueError):
    """The description of the robot (URDF) cannot be used."""

    fault = CONFIGURATION


def joint_positions(x_mm: float, y_mm: float, z_deg: float) -> Dict[str, float]:
    """Return the position of each joint [m or rad]."""
    return {Y_JOINT: y_mm / MM_PER_M, X_JOINT: x_mm / MM_PER_M, Z_JOINT: math.radians(z_deg)}


@dataclass(frozen=True)
class Joint:
    """A joint of the robot.

    Attributes:
        kind: prismatic, revolute or fixed.
        origin_m: Place of the child in the parent at position 0 [m].
        rotation: Rotation of the child at position 0 (x, y, z, w).
        axis: Direction of motion, or axis of rotation, in the child at position 0.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin_m: Vector
    rotation: Quaternion
    axis: Vector

    @property
    def is_fixed(self) -> bool:
        """Whether it never moves."""
        return self.kind == FIXED

    def transform(self, position: float = 0.0) -> LinkTransform:
        """Return where the child is with the joint at a position [m or rad]."""
        if self.kind == REVOLUTE:
            turned = product(self.rotation, about(self.axis, position))
            return LinkTransform(self.parent, self.child, self.origin_m, turned)
        x, y, z = np.add(self.origin_m, np.multiply(rotated(self.rotation, self.axis), position))
        return LinkTransform(self.parent, self.child, (x, y, z), self.rotation)


@dataclass(frozen=True)
class LinkTransform:
    """Where a link is in its parent; the rotation is x, y, z, w."""

    parent: str
    child: str
    place_m: Vector
    rotation: Quaternion


@dataclass(frozen=True)
class RobotModel:
    """The joints of the robot, in the order of its description."""

    joints: Tuple[Joint, ...]

    @classmethod
    def of(cls, urdf: str) -> RobotModel:
        """Read a description (URDF).

        Raises:
            RobotModelError: It is none, lacks a joint, or has one that is not supported.
        """
        try:
            robot = ElementTree.fromstring(urdf)
            joints = tuple(_joint(element) for element in robot.findall("joint"))
        except (ElementTree.ParseError, AttributeError, KeyError, ValueError) as error:
            raise RobotModelError(
                Message("robot_description is not a URDF of this robot", details=repr(error))
            ) from error
        names = {joint.name for joint in joints}
        missing = [name for name in JOINTS if name not in names]
        if missing:
            raise RobotModelError(Message("robot_description has no joint {name}", name=missing[0]))
        return cls(joints)

    def moving(self, positions: Mapping[str, float]) -> List[LinkTransform]:
        """Return where every link is that moves, by the positions of the joints [m or rad]."""
        return [one.transform(positions[one.name]) for one in self.joints if not one.is_fixed]

    def fixed(self) -> List[LinkTransform]:
        """Return where every link is that does not move in its parent."""
        return [one.transform() for one in self.joints if one.is_fixed]


def from_angles(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    """Return the rotation of a URDF's rpy: about the fixed axes x, then y, then z [rad]."""
    roll = about((1.0, 0.0, 0.0), roll_rad)
    pitch = about((0.0, 1.0, 0.0), pitch_rad)
    return product(about((0.0, 0.0, 1.0), yaw_rad), product(pitch, roll))


def about(axis: Vector, angle_rad: float) -> Quaternion:
    """Return the rotation about an axis."""
    x, y, z = np.multiply(axis, math.sin(angle_rad / 2.0) / np.linalg.norm(axis))
    return (x, y, z, math.cos(angle_rad / 2.0))


def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Return the rotation by `second`, then by `first`."""
    a, b, first_w, second_w = first[:3], second[:3], first[3], second[3]
    x, y, z = np.multiply(b, first_w) + np.multiply(a, second_w) + np.cross(a, b)
    return (x, y, z, first_w * second_w - float(np.dot(a, b)))


def rotated(rotation: Quaternion, vector: Vector) -> Vector:
    """Return a vector, rotated."""
    x, y, z, w = rotation
    return product(product(rotation, (*vector, 0.0)), (-x, -y, -z, w))[:3]


def _joint(element: ElementTree.Element) -> Joint:
    kind = element.attrib["type"]
    if kind not in TYPES:
        raise ValueError(f"a joint of type {kind}")
    origin, axis = element.find("origin"), element.find("axis")
    texts = {} if origin is None else origin.attrib
    direction = "1 0 0" if axis is None else axis.attrib["xyz"]
    return Joint(
        element.attrib["name"],
        kind,
        _link(element, "parent"),
        _link(element, "child"),
        _vector(texts.get("xyz", "0 0 0")),
        from_angles(*_vector(texts.get("rpy", "0 0 0"))),
        _vector(direction),
    )


def _link(element: ElementTree.Element, role: str) -> str:
    found = element.find(role)
    if found is None:
        raise ValueError(f"a joint without {role}")
    return found.attrib["link"]


def _vector(text: str) -> Vector:
    x, y, z = (float(one) for one in text.split())
    return (x, y, z)
