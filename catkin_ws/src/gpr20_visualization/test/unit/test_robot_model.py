"""The URDF, and the files for RViz and Foxglove name what there is."""

import json
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml
from fault_kit import raises_fault

from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.yaml_file import read_yaml
from gpr20_survey import axes as frames
from gpr20_visualization.mid.robot_model import (
    X_JOINT,
    Y_JOINT,
    Z_JOINT,
    RobotModel,
    RobotModelError,
    from_angles,
    joint_positions,
    rotated,
)

PACKAGE = Path(__file__).resolve().parents[2]
URDF = PACKAGE / "urdf" / "gpr20.urdf"


@pytest.fixture
def model():
    return RobotModel.of(URDF.read_text())


def test_the_frames_are_those_of_the_project(model):
    links = {joint.child for joint in model.joints} | {joint.parent for joint in model.joints}
    assert links == FRAMES - {frames.MAP}


def test_the_travel_is_that_of_the_axes():
    axes = read_yaml(PACKAGE.parent / "gpr20_launch" / "config" / "axes.yaml")
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
    (sensor,) = model.fixed()
    assert sensor.child == frames.HEIGHT_SENSOR_LINK
    assert rotated(sensor.rotation, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 0.0, -1.0))
    assert rotated(antennas.rotation, (1.0, 0.0, 0.0)) == pytest.approx((0.0, 1.0, 0.0))


def test_angles_turn_about_x_then_y_then_z():
    for angles in ((math.pi / 2, math.pi / 2, 0.0), (0.3, math.pi / 2, math.pi / 2)):
        x_axis = rotated(from_angles(*angles), (1.0, 0.0, 0.0))
        assert x_axis == pytest.approx((0.0, 0.0, -1.0))


def test_refuses_what_is_not_a_description_of_the_robot():
    for text in ("no XML", "<robot/>", "<robot><joint name='a' type='fixed'/></robot>"):
        with raises_fault(CONFIGURATION, error=RobotModelError):
            RobotModel.of(text)


NODES = {
    *(f"{axis}_axis/axis_driver: state" for axis in "xyz"),
    *(f"{name}: state" for name in ("height_sensor", "vna_acquisition", "vna_processing")),
    *(f"{name}: state" for name in ("main_control", "imaging", "visualization", "simulator")),
    *("user_interface: state", "web: state"),
}
FRAMES = {value for name, value in vars(frames).items() if re.search("^MAP$|_LINK$", name)}
# What the layout and the configuration show, without the slash of the layout's absolute names.
SHOWN = {
    *("b_scan", "survey_area", "stops", "candidate_markers", "measured_height"),
    *("robot_description", "joint_states", "trace", "control_status", "control_survey_data"),
    *("diagnostics", "candidates"),
}


def values(node, keys):
    """Yield the texts that stand under some keys, at any depth."""
    items = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in items:
        if key in keys and isinstance(value, str) and value:
            yield value
        elif isinstance(value, (dict, list)):
            yield from values(value, keys)


def test_the_layout_shows_topics_and_frames_that_exist():
    layout = json.loads((PACKAGE / "foxglove" / "gpr20.json").read_text())
    keys = {"topic", "imageTopic", "topicPath", "topicToRender", "value"}
    named = {text.split(".")[0].lstrip("/") for text in values(layout, keys)}
    robot = layout["configById"]["3D!robot"]
    named |= {topic.lstrip("/") for topic in robot["topics"]}
    assert named == SHOWN
    assert {name.split(":")[1] for name in robot["transforms"]} == FRAMES
    assert {robot["fixedFrame"], robot["followTf"]} <= FRAMES


def test_rviz_shows_topics_and_frames_that_exist():
    config = yaml.safe_load((PACKAGE / "rviz" / "gpr20.rviz").read_text())
    manager = config["Visualization Manager"]
    topics = set(values(manager, {"Topic", "Marker Topic", "Image Topic", "Robot Description"}))
    # Relative names: RViz in the namespace of a robot shows that robot.
    assert topics <= SHOWN
    assert set(values(manager, {"Fixed Frame", "Target Frame", "Reference Frame"})) <= FRAMES
