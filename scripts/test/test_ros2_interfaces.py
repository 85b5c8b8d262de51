"""The interfaces for ROS 2 are those of ROS 1, and ROS 2's compiler builds them."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest
import ros2_interfaces
from case_kit import each_case
from rosbags.typesys import get_types_from_msg
from user_shell import ROOT, printed_by

ROS1 = ROOT / "catkin_ws/src/gpr20_msgs"
ROS2 = ROOT / "ros2/gpr20_msgs"
FOUND = ros2_interfaces.interfaces(ROS1)
ACTION_MESSAGES = [
    f"Axis{action}{part}" for action in ("", "Action") for part in ("Goal", "Result", "Feedback")
]
WRITTEN = sorted(path for path in ROS1.glob("*/*.*") if path.suffix[1:] == path.parent.name)

# What Debian does not have of ROS 2. What is in these messages does not matter to ours.
STUBS = {
    "builtin_interfaces": ("msg/Time.msg", "msg/Duration.msg"),
    "unique_identifier_msgs": ("msg/UUID.msg",),
    "std_msgs": ("msg/Header.msg",),
    "actionlib_msgs": ("msg/GoalID.msg", "msg/GoalStatus.msg"),
    "action_msgs": ("msg/GoalInfo.msg", "msg/GoalStatusArray.msg", "srv/CancelGoal.srv"),
}
GENERATORS = ("rosidl_cmake", "rosidl_generator_cpp")


def parts_of(text: str) -> list[dict]:
    """Return constants and fields of each part of a definition, as another library reads them."""
    text = re.sub(r"^string operator(?=\s)", "string operator_name", text, flags=re.MULTILINE)
    parts = re.split(r"^---$", text, flags=re.MULTILINE)
    return [dict(get_types_from_msg(f"{part.strip()}\n", "gpr20_msgs/msg/Part")) for part in parts]


def test_every_interface_has_the_constants_and_fields_of_ros1():
    listed = {f"{one.parent.name}/{one.name}": one.read_text(encoding="utf-8") for one in WRITTEN}
    assert set(FOUND) == listed.keys() | {f"msg/{name}.msg" for name in ACTION_MESSAGES}
    for name, text in listed.items():
        assert parts_of(FOUND[name]) == parts_of(text), name
        assert not re.search(r"^(time|duration)\b", FOUND[name], re.MULTILINE)


@each_case("line", ["float64 Height", "float64 a__b", "float64 a_", "float64", "X=1"])
def test_a_name_that_ros2_does_not_allow_is_refused(line, tmp_path):
    (tmp_path / "msg").mkdir(exist_ok=True)
    (tmp_path / "msg/Wrong.msg").write_text(f"{line}\n")
    script = (sys.executable, ROS2 / "ros2_interfaces.py", tmp_path, tmp_path / "out")
    said = printed_by(*script, status=1)
    assert "Wrong.msg" in said and repr(line)[1:-1] in said
    assert not (tmp_path / "out").exists()


def build(source, place):
    install = place / "install"
    prefix = f"{install}:/usr"
    folder = place / "build" / source.name
    for command in (
        ["-S", source, "-B", folder, f"-DCMAKE_INSTALL_PREFIX={install}"]
        # Debian's, which has the modules of rosidl.
        + ["-DPython3_EXECUTABLE=/usr/bin/python3", "-DBUILD_TESTING=OFF"],
        ["--build", folder, "--parallel", "2", "--target", "install"],
    ):
        printed_by("cmake", *command, AMENT_PREFIX_PATH=prefix, CMAKE_PREFIX_PATH=prefix)


def write_stub(folder, files):
    """Write a package that stands for one of ROS 2."""
    for file in files:
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text("uint8 any\n---\n" if file.endswith(".srv") else "uint8 any\n")
    (folder / "package.xml").write_text(
        f'<package format="3"><name>{folder.name}</name><version>0.0.0</version><description>stub'
        '</description><maintainer email="a@b.example">a</maintainer><license>GPL</license>'
        "<member_of_group>rosidl_interface_packages</member_of_group></package>"
    )
    (folder / "CMakeLists.txt").write_text(
        f"cmake_minimum_required(VERSION 3.10)\nproject({folder.name})\n"
        "find_package(ament_cmake REQUIRED)\nfind_package(rosidl_default_generators REQUIRED)\n"
        f"rosidl_generate_interfaces({folder.name} {' '.join(files)})\nament_package()\n"
    )


@pytest.mark.release
@pytest.mark.skipif(
    not Path("/usr/share/rosidl_cmake").is_dir(), reason="Debian's rosidl-core is not installed"
)
def test_the_compiler_of_ros2_builds_every_interface(tmp_path):
    shim = tmp_path / "install/share/rosidl_default_generators/cmake"
    shim.mkdir(parents=True)
    (shim / "rosidl_default_generatorsConfig.cmake").write_text(
        "".join(f"find_package({one} REQUIRED)\n" for one in GENERATORS)
    )
    for name, files in STUBS.items():
        write_stub(tmp_path / name, files)
        build(tmp_path / name, tmp_path)
    build(ROS2, tmp_path)

    headers = sorted((tmp_path / "install/include/gpr20_msgs/gpr20_msgs").glob("*/*.hpp"))
    assert len(headers) >= len(FOUND)
    program = tmp_path / "all.cpp"
    program.write_text("".join(f'#include "{one}"\n' for one in headers))
    places = [f"-I{one}" for one in (tmp_path / "install/include").iterdir()]
    places += [f"-I{one}" for one in Path("/usr/include").glob("rosidl_*")]
    printed_by("g++", "-std=c++17", "-fsyntax-only", program, *places)
