"""A launch file of the original software becomes a configuration, and says what became of what."""

import pytest
import yaml
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import assume, given
from hypothesis import strategies as st
from robot_check_examples import AXES as BUILT
from robot_check_examples import checked, write

from gpr20_common.faults import NOT_ALLOWED
from gpr20_launch.faults import NOT_CHECKED, LaunchRefusedError
from gpr20_launch.mid.old_launch import NAMES, OldRobot, old_robot, read

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
    robot = old_robot(path, yaml.safe_load(BUILT.read_text()))
    axes = yaml.safe_load(robot.texts["axes.yaml"])
    return axes, robot


WHOLE = "".join(node(params(AXES[axis]), axis) for axis in "xyz")
# What groups, arguments, expressions, names and conditions mean, roslaunch says below.
FORMS = {
    "nodes with a namespace": WHOLE,
    "names of nodes": "".join(node(params(AXES[axis]), name=f"axis_{axis}") for axis in "xyz"),
    "rosparam of all": "<rosparam>"
    + yaml.safe_dump({f"{axis}_axis": AXES[axis] for axis in "xyz"})
    + "</rosparam>",
}


@each_case("form", sorted(FORMS))
def test_every_form_of_a_launch_file_means_the_same(tmp_path, form):
    axes, robot = imported(launch(tmp_path, FORMS[form]))
    wanted = {axis: {**AXES[axis], "invert_direction": True} for axis in "xyz"}
    wanted["z"]["sensor_pin"] = None
    # The original's axis node sets its direction pin to `not direction`, and z has no endstop.
    assert axes == wanted and not robot.values and not robot.unread


def test_includes_and_files_are_found_beside_the_launch_file(tmp_path):
    robot_folder = tmp_path / "gpr20_robot"
    (robot_folder / "config").mkdir(parents=True)
    (robot_folder / "config/z.yaml").write_text(yaml.safe_dump({**Z, "step_pin": "$(arg step)"}))
    # A file of the same name elsewhere is another one.
    launch(tmp_path, node(params(Y), "x"), "launch/axes.launch")
    load = 'command="load" subst_value="true" file="$(find gpr20_robot)/config/z.yaml"'
    inner = (
        '<arg name="pin"/><arg name="step" default="40"/>'
        + node(params({**X, "dir_pin": "$(arg pin)"}), "x")
        + node(f"<rosparam {load}/>", "z")
    )
    launch(robot_folder, inner, "launch/axes.launch")
    for file in ("$(find gpr20_robot)/launch/axes.launch", "$(dirname)/axes.launch"):
        passed = '<arg name="step" value="31"/>'
        arguments = '<arg name="pin" value="29"/><arg name="pin" value="3" unless="1"/>'
        include = f'<include file="{file}" pass_all_args="true">{arguments}</include>'
        path = launch(robot_folder, passed + include, "launch/GPR20_robot.launch")
        axes, robot = imported(path)
        assert axes["x"]["dir_pin"] == 29 and axes["z"]["step_pin"] == 31
        assert "does not set y" in axes["y"]["dir_pin"] and "does not set y" in robot.unread[0]


def test_what_another_robot_has_otherwise_passes_the_check(tmp_path):
    fast = WHOLE.replace('"min_step" value="0.0015"', '"min_step" value="0.0004"', 1)
    height = node(params({"channel": 3, "rate": 5}), name="gpr20_height_sensor")
    axes, robot = imported(launch(tmp_path, fast + height))
    assert yaml.safe_load(robot.texts["height.yaml"]) == {"channel": 3}
    assert list(robot.values) == ["/gpr20_height_sensor/rate"]
    assert axes["x"]["late_limit_s"] < 0.0004 and "late_limit_s" not in axes["y"]
    write(tmp_path / "robot", robot.texts)
    assert {one.key for one in checked(tmp_path / "robot", part="robot")} == {"unchecked"}


X_NODE = node(params({key: X[key] for key in NAMES if key != "dir_pin"}) + "{}", "x")
X_NODE += node(params(Y), "y") + node(params(Z), "z")
EXPRESSIONS = ["__import__('os').getpid()", "int(", "(" * 300]
# Beside what is inside of the node of x; what must be said.
UNREAD = [
    ('<param name="dir_pin" value="$(env PIN)"/>', "", "$(env PIN)"),
    ('<param name="dir_pin" command="cat pin"/>', "", "cat pin"),
    ('<param name="dir_pin" value="$(arg pin)"/>', "", "$(arg pin)"),
    ('<param name="$(env A)" value="13"/>', "", "$(env A)"),
    ('<rosparam command="load" file="$(find a)/a.yaml"/>', "", "find a"),
    ("<rosparam>[</rosparam>", "", "not YAML"),
    ('<rosparam file="/etc/passwd"/>', "", "only a .yaml file"),
    ('<rosparam file="$(dirname)/GPR20_robot.launch"/>', "", "only a .yaml file"),
    ('<rosparam file="$(dirname)/secret.yaml"/>', "", "cannot be used"),
    ("", '<include file="$(find other)/gone.launch"/>', "gone"),
    ("", f'<group if="$(env A)">{node(params(X), "x")}</group>', "env A"),
    *((f'<param name="dir_pin" value="$(eval {one})"/>', "", "eval") for one in EXPRESSIONS),
]


@each_case("inside, beside, shown", UNREAD)
def test_what_cannot_be_read_is_asked_for_and_no_default_counts(tmp_path, inside, beside, shown):
    folder = tmp_path / str(UNREAD.index((inside, beside, shown)))
    path = launch(folder, X_NODE.format(inside) + beside)
    (folder / "secret.yaml").write_text("[root:x")
    _axes, robot = imported(path)
    assert "root:x" not in str(robot)
    write(folder / "robot", robot.texts)
    found = [one for one in checked(folder / "robot", part="robot") if one.key != "unchecked"]
    assert [one.key for one in found if one.key.startswith("x")] == ["x/dir_pin"], found
    for text in (str(one.message) for one in found):
        assert path.name in text and shown in text and "write it" in text, text


PIN = '<param name="gpr20_x_axis/gpr20_axis/dir_pin" value="32"/>'
# What may replace values of a file that is complete otherwise, and what must be said.
OVERRIDES = [
    (WHOLE + PIN, "32"),
    (WHOLE + params({"x_axis/dir_pin": 12}), "12"),
    (WHOLE + f'<group if="$(env BOARD)">{PIN}</group>', "env BOARD"),
    (WHOLE + '<rosparam command="delete" param="/gpr20_x_axis"/>', "delete"),
    (WHOLE.replace('name="', 'args="_dir_pin:=29" name="', 1), "args mean"),
    (WHOLE + params({"~dir_pin": 32}), "~dir_pin"),
    (WHOLE.replace("<node", '<param name="/x/dir_pin" value="3"/><node', 1), "/x/dir_pin"),
    (WHOLE + '<rosparam file="$(find x_axis_driver)/config/x.yaml"/>', "x_axis_driver"),
]


@each_case("inner, shown", OVERRIDES)
def test_a_part_that_may_replace_values_refuses_the_launch_until_a_person_has_looked(
    tmp_path, inner, shown
):
    (tmp_path / "bringup/config").mkdir(parents=True, exist_ok=True)
    (tmp_path / "bringup/config/x.yaml").write_text("{gpr20_x_axis: {gpr20_axis: {dir_pin: 3}}}")
    axes, robot = imported(launch(tmp_path / "bringup/launch", inner))
    assert axes["x"]["dir_pin"] == X["dir_pin"] and shown in robot.unread[0]
    assert yaml.safe_load(robot.texts["wiring.yaml"])["unchecked"][0] == "unread"
    write(tmp_path / "robot", robot.texts)
    found = checked(tmp_path / "robot", part="robot")
    assert any(one.value == "unread" and one.refuses for one in found)


@each_case(
    "text, shown",
    [
        ("<robot/>", "not a launch file"),
        ("<launch>", "not a launch file"),
        ('<!DOCTYPE x [<!ENTITY a "b">]><launch>&a;</launch>', "not a launch file"),
        (f"<launch>{params({'dir_pin': 3})}</launch>", "no parameter of an axis"),
        ("<launch>" + " " * (1 << 20) + "</launch>", "larger than"),
    ],
)
def test_what_is_no_launch_file_of_the_robot_is_refused(tmp_path, text, shown):
    path = tmp_path / "old.launch"
    path.write_text(text)
    with raises_fault(NOT_ALLOWED, path, shown, error=LaunchRefusedError):
        imported(path)


def test_files_that_include_each_other_end(tmp_path):
    again = '<include file="$(find a)/old.launch"/>'
    (tmp_path / "a").mkdir()
    path = launch(tmp_path / "a", node(params(X), "x") + again * 3, "old.launch")
    with raises_fault(NOT_ALLOWED, path, "too deeply", error=LaunchRefusedError):
        imported(path)
    deep = "<group>" * 5000 + node(params(X), "x") + "</group>" * 5000
    with raises_fault(NOT_ALLOWED, "too deeply", error=LaunchRefusedError):
        imported(launch(tmp_path, deep))
    copies = "".join(f"a{n + 1}: &a{n + 1} {{b: *a{n}, c: *a{n}}}\n" for n in range(28))
    text = f"<rosparam>a0: &a0 {{d: 1}}\n{copies}</rosparam>".replace("&", "&amp;")
    assert "could not be read" in imported(launch(tmp_path, WHOLE + text))[1].unread[0]


def test_the_command_writes_once_and_what_it_wrote_passes_but_for_the_person(
    tmp_path, monkeypatch, run
):
    monkeypatch.setenv("GPR20_STATE", str(tmp_path / "state"))

    def run_import(inner, folder):
        return run("robot_config", "import", launch(tmp_path, inner), folder)

    folder = tmp_path / "robot"
    status, said, _ = run_import(WHOLE, folder)
    assert status == 0
    assert all(f"{one}:" in said for one in ("not found out", "without a counterpart"))
    found = checked(folder, part="robot")
    assert {one.message.fault_code for one in found} == {NOT_CHECKED.code}
    assert any(one.refuses for one in found)
    before = {one.name: one.read_bytes() for one in folder.iterdir()}
    assert "axes.yaml" in before and "survey.yaml" in before
    status, _, said = run_import(WHOLE, folder)
    assert status == 1 and "stay as they are" in said
    assert {one.name: one.read_bytes() for one in folder.iterdir()} == before
    # The direction of z on the pin of y's endstop, as in the group's packages, is found; so is
    # what could not be read, also where every value is there.
    pin = WHOLE.replace('value="38"', 'value="11"')
    more = WHOLE + '<include file="$(find other)/more.launch"/>'
    little = node(params({"dir_pin": 3}), "x")  # what no part sets is one mistake
    for inner, shown in ((pin, "y/sensor_pin"), (more, "more.launch"), (little, "not set y")):
        status, said, _ = run_import(inner, tmp_path / shown)
        assert status == 1 and shown in said and said.count("UNREAD") == (inner is little)


# Each of them is something else as a number, as a text and as YAML.
TEXTS = st.sampled_from(["1", "013", "1e3", "0x1f", ".5", "nan", "TRUE", "no"])
SPACES = st.sampled_from(["", 'ns="x_axis"', 'ns="/y_axis"'])
PARAMS = st.builds(
    '<param name="{}" {} value="{}"/>'.format,
    st.sampled_from("abcde"),
    st.sampled_from(["", "", 'type="str"']),
    TEXTS | st.just("$(arg a)"),
)
ROSPARAMS = st.builds(
    "<rosparam {}>{{ {}: {}, f: {} }}</rosparam>".format,
    st.sampled_from(["", 'ns="below"', 'param="/whole"']),
    # 013 is 11 for roslaunch; here it is a text, which no launch accepts.
    *(st.sampled_from("gh"), TEXTS.filter("013".__ne__), st.integers(0, 9)),
)
NODES = st.builds(
    '<node pkg="p" type="t" name="{}" {}>{}</node>'.format,
    st.sampled_from(["n", "m"]),
    SPACES,
    st.lists(PARAMS | ROSPARAMS, max_size=3).map("".join),
)
INCLUDES = st.builds('<include file="$(dirname)/inner.launch" {}/>'.format, SPACES)


def groups(elements):
    condition = st.sampled_from(["", "", 'if="$(arg used)"', 'unless="0"', 'if="false"'])
    inner = st.lists(elements, max_size=3).map("".join)
    return st.builds("<group {} {}>{}</group>".format, SPACES, condition, inner)


def launches(leaves):
    texts = st.lists(st.recursive(leaves, groups, max_leaves=6), max_size=4).map("".join)
    return texts.map('<arg name="a" default="3"/><arg name="used" default="true"/>{}'.format)


@given(launches(PARAMS | ROSPARAMS | NODES | INCLUDES), launches(PARAMS | ROSPARAMS | NODES))
def test_parameters_are_those_that_roslaunch_sets(tmp_path_factory, outer, inner):
    roslaunch = pytest.importorskip("roslaunch")
    folder = tmp_path_factory.mktemp("launch")
    launch(folder, inner, "inner.launch")
    path = launch(folder, outer)
    wanted, found = roslaunch.config.ROSLaunchConfig(), OldRobot()
    try:
        roslaunch.xmlloader.XmlLoader().load(str(path), wanted, verbose=False)
    except roslaunch.core.RLException:
        assume(False)  # as two nodes of one name
    read(path, found)
    # What is set twice, and counts or not by the order, is asked for.
    assume(not found.unread)
    whole = {}
    for name, param in wanted.params.items():
        inner_values = param.value if isinstance(param.value, dict) else {"": param.value}
        whole.update({f"{name}/{key}".rstrip("/"): one for key, one in inner_values.items()})
    # By their texts: 1 is not True, and nan is nan.
    assert repr(sorted(found.values.items())) == repr(sorted(whole.items()))
