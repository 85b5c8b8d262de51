"""The files for RViz, Foxglove and diagnostic_aggregator name what there is."""

import json
from pathlib import Path

import pytest
import yaml

from gpr20_survey import frames

PACKAGE = Path(__file__).resolve().parents[2]
NODES = {
    *(f"{axis}_axis/axis_driver: state" for axis in "xyz"),
    *(f"{name}: state" for name in ("height_sensor", "vna_acquisition", "vna_processing")),
    *(f"{name}: state" for name in ("main_control", "imaging", "visualization", "simulator")),
    *("user_interface: state", "web: state"),
}
FRAMES = {value for name, value in vars(frames).items() if name.isupper()}
# What the layout and the configuration show, without the slash of the layout's absolute names.
SHOWN = {
    *("b_scan", "survey_area", "stops", "candidate_markers", "measured_height"),
    *("robot_description", "joint_states", "trace", "control_status", "control_survey_data"),
    *("diagnostics", "candidates"),
}


@pytest.fixture
def layout():
    return json.loads((PACKAGE / "foxglove" / "gpr20.json").read_text())


def panels(node):
    if isinstance(node, str):
        return [node]
    return panels(node["first"]) + panels(node["second"])


def values(node, keys):
    """Yield the texts that stand under some keys, at any depth."""
    items = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in items:
        if key in keys and isinstance(value, str) and value:
            yield value
        elif isinstance(value, (dict, list)):
            yield from values(value, keys)


def test_the_layout_shows_each_of_its_panels_once(layout):
    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])


def test_the_layout_shows_topics_and_frames_that_exist(layout):
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


def test_the_aggregator_has_every_node_in_one_group():
    config = yaml.safe_load((PACKAGE / "diagnostics" / "aggregator.yaml").read_text())
    for node in NODES:
        groups = [
            one["path"]
            for one in config["analyzers"].values()
            if any(part in node for part in one["contains"])
        ]
        assert len(groups) == 1, (node, groups)
