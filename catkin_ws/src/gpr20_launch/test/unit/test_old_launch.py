"""A launch file of the original software becomes a configuration, and says what became of what."""

import sys

import pytest
import yaml
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from robot_check_examples import BUILT, checked

from gpr20_launch import faults
from gpr20_launch.errors import OldLaunchError
from gpr20_launch.mid.old_launch import read_launch
from gpr20_launch.mid.old_robot import NAMES, old_robot

X = {
    **{"dir_pin": 13, "step_pin": 15, "sensor_pin": 7, "step_size": 0.01, "min_step": 0.0015},
    **{"max_step": 0.005, "delta_step": 0.0001, "min_coord": 0, "max_coord": 640.5},
    "type": "LIN",
}
Y = {**X, "dir_pin": 16, "step_pin": 18, "sensor_pin": 11, "max_coord": 790.0}
Z = {
    **{"dir_pin": 38, "step_pin": 40, "sensor_pin": -1, "step_size": 1.8, "min_step": 0.01},
    **{"max_step": 0.025, "delta_step": 0.005, "min_coord": -90, "max_coord": 90, "type": "ROT"},
}
AXES = {"x": X, "y": Y, "z": Z}


def params(values):
    return "".join(f'<param name="{key}" value="{value}"/>' for key, value in values.items())


def node(inner, axis="", name="gpr20_axis"):
    space = f'ns="gpr20_{axis}_axis" ' if axis else ""
    return f'<node {space}pkg="gpr20_axis_driver" type="axis_node" name="{name}">{inner}</node>'


def launch(folder, inner, name="GPR20_robot.launch"):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"<launch>{inner}</launch>")
    return path


def imported(path):
    """Return the axes of the configuration and everything that the import says."""
    robot = old_robot(path, read_launch(path), yaml.safe_load(BUILT.axes.read_text()))
    axes = yaml.safe_load(robot.texts["axes.yaml"])
    return axes, robot


FORMS = {
    "nodes with a namespace": "".join(node(params(AXES[axis]), axis) for axis in "xyz"),
    "groups": "".join(
        f'<group ns="gpr20_{axis}_axis">{node(params(AXES[axis]))}</group>' for axis in "xyz"
    ),
    "names of nodes": "".join(node(params(AXES[axis]), name=f"axis_{axis}") for axis in "xyz"),
    "private names": "".join(
        node(params({f"~{key}": value for key, value in AXES[axis].items()}), axis)
        for axis in "xyz"
    ),
    "whole names": params(
        {f"/gpr20_{axis}_axis/gpr20_axis/{key}": AXES[axis][key] for axis in "xyz" for key in NAMES}
    ),
    "rosparam": "".join(
        node(f"<rosparam>{yaml.safe_dump(AXES[axis])}</rosparam>", axis) for axis in "xyz"
    ),
    "rosparam of all": "<rosparam>"
    + yaml.safe_dump({f"{axis}_axis": AXES[axis] for axis in "xyz"})
    + "</rosparam>",
    "args": "".join(
        "".join(f'<arg name="{axis}_{key}" default="{AXES[axis][key]}"/>' for key in NAMES)
        + node(params({key: f"$(arg {axis}_{key})" for key in NAMES}), axis)
        for axis in "xyz"
    ),
    "conditions": '<arg name="real" default="true"/>'
    + "".join(node(params(AXES[axis]), axis) for axis in "xyz")
    + f'<group unless="$(arg real)">{node(params({"dir_pin": 3}), "x")}</group>',
}


@each_case("form", sorted(FORMS))
def test_every_form_of_a_launch_file_means_the_same(tmp_path, form):
    axes, robot = imported(launch(tmp_path, FORMS[form]))
    wanted = {axis: {**AXES[axis], "invert_direction": True} for axis in "xyz"}
    del wanted["z"]["sensor_pin"]
    assert axes == wanted and robot.left == []
    assert len(robot.taken) == 29 and "x/max_coord: 640.5 mm" in robot.taken
    assert any("z/sensor_pin: -1 -> left out" in one for one in robot.changed)
    # The original's axis node sets its direction pin to `not direction`.
    assert sum("invert_direction: true" in one for one in robot.changed) == 3


def test_includes_and_files_are_found_beside_the_launch_file(tmp_path):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/z.yaml").write_text(yaml.safe_dump(Z))
    inner = (
        '<arg name="pin"/>'
        + node(params({**X, "dir_pin": "$(arg pin)"}), "x")
        + node('<rosparam command="load" file="$(find gpr20_robot)/config/z.yaml"/>', "z")
    )
    launch(tmp_path, inner, "launch/axes.launch")
    path = launch(
        tmp_path,
        '<include file="$(find gpr20_robot)/launch/axes.launch"><arg name="pin" value="29"/>'
        "</include>",
        "launch/GPR20_robot.launch",
    )
    axes, robot = imported(path)
    assert axes["x"]["dir_pin"] == 29 and axes["z"]["step_pin"] == 40 and "y" not in axes
    assert "y/sensor_pin: not in the file, so the default counts: 40" in robot.changed


def test_what_has_no_counterpart_or_cannot_be_resolved_is_named(tmp_path):
    inner = (
        node(params(X), "x")
        + params({"rate": 100, "vna_ip": "192.168.1.20", "who": "$(env USER)"})
        + '<param name="robot_description" command="rm -rf /"/>'
        + '<include file="$(find other)/launch/gone.launch"/>'
    )
    _axes, robot = imported(launch(tmp_path, inner))
    left = "\n".join(robot.left)
    assert all(one in left for one in ("/rate: 100", "who", "robot_description", "gone.launch"))
    assert robot.texts["analyzer.yaml"].endswith("address: 192.168.1.20\n")


@each_case(
    "text, shown",
    [
        ("", "not a launch file"),
        ("<robot/>", "not a launch file"),
        ("<launch>", "not a launch file"),
        ('<!DOCTYPE x [<!ENTITY a "b">]><launch>&a;</launch>', "not a launch file"),
        ("<launch/>", "no parameter of an axis"),
        (f"<launch>{params({'dir_pin': 3})}</launch>", "no parameter of an axis"),
        ("<launch>" + " " * (1 << 20) + "</launch>", "not a launch file"),
    ],
)
def test_what_is_no_launch_file_of_the_robot_is_refused(tmp_path, text, shown):
    path = tmp_path / "old.launch"
    path.write_text(text)
    with raises_fault(faults.OLD_LAUNCH, path, shown, error=OldLaunchError):
        imported(path)


def test_files_that_include_each_other_end(tmp_path):
    again = '<include file="$(find a)/old.launch"/>'
    path = launch(tmp_path, node(params(X), "x") + again * 3, "old.launch")
    axes, robot = imported(path)
    assert axes["x"]["dir_pin"] == 13 and robot.left
    deep = "<group>" * 500 + node(params(X), "x") + "</group>" * 500
    assert "too deeply" in str(read_launch(launch(tmp_path, deep)).unresolved)


@given(
    st.recursive(
        st.sampled_from(
            ["<param name='x_axis/dir_pin' value='$(arg a)'/>", "<rosparam>[</rosparam>"]
        )
        | st.text("<>/= \"'$()abxyz_{}:", max_size=20),
        lambda inner: st.lists(inner, max_size=3).map(
            lambda parts: f"<group ns='x' if='1'>{''.join(parts)}</group>"
        ),
        max_leaves=6,
    )
)
def test_any_file_is_read_or_refused(tmp_path_factory, text):
    path = launch(tmp_path_factory.mktemp("old"), text)
    try:
        imported(path)
    except OldLaunchError as error:
        assert str(path) in str(error)


def test_the_command_writes_once_and_what_it_wrote_passes_but_for_the_person(
    tmp_path, monkeypatch, capsys
):
    main = pytest.importorskip("gpr20_launch.high.robot_config").main
    monkeypatch.setenv("GPR20_STATE", str(tmp_path / "state"))
    path = launch(tmp_path, FORMS["groups"])
    folder = tmp_path / "robot"
    monkeypatch.setattr(sys, "argv", ["robot_config", "import", str(path), str(folder)])
    assert main() == 0
    said = capsys.readouterr().out
    assert all(f"{one}:" in said for one in ("taken", "changed", "without a counterpart here"))
    found = checked(folder, stores=False)
    assert {one.message.fault_code for one in found} == {faults.NOT_CHECKED.code}
    assert any(one.refuses for one in found)
    before = {one.name: one.read_bytes() for one in folder.iterdir()}
    assert "axes.yaml" in before and "survey.yaml" in before
    assert main() == 1
    assert "stay as they are" in capsys.readouterr().err
    assert {one.name: one.read_bytes() for one in folder.iterdir()} == before
    # The direction of z on the pin of y's endstop, as in the group's packages, is found.
    wrong = launch(tmp_path, FORMS["groups"].replace('value="38"', 'value="11"'))
    monkeypatch.setattr(sys, "argv", ["robot_config", "import", str(wrong), str(tmp_path / "b")])
    assert main() == 0
    assert "pin 11 (GPIO17) has 2 purposes: axes.yaml y/sensor_pin" in capsys.readouterr().out
