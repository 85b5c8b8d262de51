"""The URDF of the robot: its frames, its travel and where its links are."""

import math
import shutil
import subprocess
from pathlib import Path

import pytest
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common.low.yaml_file import read_yaml
from gpr20_survey import frames
from gpr20_visualization.errors import RobotModelError
from gpr20_visualization.faults import WRONG_DESCRIPTION
from gpr20_visualization.mid.axis_position import JOINTS, X_JOINT, Y_JOINT, Z_JOINT, joint_positions
from gpr20_visualization.mid.robot_model import RobotModel, from_angles, rotated

SOURCES = Path(__file__).resolve().parents[3]
URDF = SOURCES / "gpr20_visualization" / "urdf" / "gpr20.urdf"


@pytest.fixture
def model():
    return RobotModel.of(URDF.read_text(), JOINTS)


def test_the_frames_are_those_of_the_project(model):
    links = {joint.child for joint in model.joints} | {joint.parent for joint in model.joints}
    own = {value for name, value in vars(frames).items() if name.isupper()}
    assert links == own - {frames.MAP}


def test_the_travel_is_that_of_the_axes():
    from xml.etree import ElementTree

    axes = read_yaml(SOURCES / "gpr20_launch" / "config" / "axes.yaml")
    limits = {one.get("name"): one.find("limit") for one in ElementTree.parse(URDF).iter("joint")}
    for joint, axis, unit in (
        (X_JOINT, "x", 0.001),
        (Y_JOINT, "y", 0.001),
        (Z_JOINT, "z", math.radians(1.0)),
    ):
        for end, key in (("lower", "min_coord"), ("upper", "max_coord")):
            assert float(limits[joint].get(end)) == pytest.approx(axes[axis][key] * unit)


def test_the_antennas_are_where_the_axes_are(model):
    positions = joint_positions(x_mm=120.0, y_mm=340.0, z_deg=90.0)
    y_carriage, x_carriage, antennas = model.moving(positions)
    assert y_carriage.place_m == (0.0, 0.34, 0.43)
    assert x_carriage.place_m == (0.12, 0.0, 0.0)
    assert antennas.place_m == (0.0, 0.0, -0.23)
    assert rotated(antennas.rotation, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))


def test_the_height_is_measured_downwards(model):
    (sensor,) = model.fixed()
    assert sensor.child == frames.HEIGHT_SENSOR_LINK
    assert rotated(sensor.rotation, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 0.0, -1.0))


@each_case(
    "angles, x_axis",
    [
        ((0.0, 0.0, math.pi / 2), (0.0, 1.0, 0.0)),
        ((math.pi / 2, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((math.pi / 2, math.pi / 2, 0.0), (0.0, 0.0, -1.0)),
        ((0.3, math.pi / 2, math.pi / 2), (0.0, 0.0, -1.0)),
    ],
)
def test_angles_turn_about_x_then_y_then_z(angles, x_axis):
    assert rotated(from_angles(*angles), (1.0, 0.0, 0.0)) == pytest.approx(x_axis)


@each_case(
    "text",
    [
        "",
        "no XML",
        "<robot/>",
        "<robot><joint name='a' type='floating'/></robot>",
        "<robot><joint name='a' type='fixed'/></robot>",
        "<robot><joint type='fixed'><parent link='b'/><child link='c'/></joint></robot>",
    ],
)
def test_refuses_what_is_not_a_description_of_the_robot(text):
    with raises_fault(WRONG_DESCRIPTION, error=RobotModelError):
        RobotModel.of(text, JOINTS)


@pytest.mark.skipif(shutil.which("check_urdf") is None, reason="needs liburdfdom-tools")
def test_check_urdf_accepts_it():
    checked = subprocess.run(["check_urdf", str(URDF)], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout
    assert "root Link: base_link" in checked.stdout
