"""What a package imports it depends on, what it reads is installed; versions and pins agree."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from case_kit import each_case
from user_shell import ROOT

from gpr20_doctor.mid.software_checks import MODULES, NEEDED

SOURCES = ROOT / "catkin_ws" / "src"
PACKAGES = {
    re.search("<name>(.*)</name>", path.read_text()).group(1): path.parent.resolve()
    for path in sorted(SOURCES.glob("*/package.xml"))
}
OUR_KEYS = yaml.safe_load((ROOT / "rosdep/gpr20.yaml").read_text())
# Keys of other modules: ours are `python3-<module>-pip`, those of ROS have their own name.
KEYS = {
    "PyQt5": "python3-pyqt5",
    "numpy": "python3-numpy",
    "psutil": "python3-psutil",
    "rospkg": "python3-rospkg",
    "skrf": "python3-scikit-rf-pip",
    "yaml": "python3-yaml",
}
# Imported on the real robot alone: requirements/robot.in.
ROBOT_MODULES = {"RPi", "spidev"}
# Imported by others on behalf of a package: h5netcdf by xarray, h5py by h5netcdf, PyVISA-py by
# PyVISA.
INDIRECT_KEYS = {"python3-h5netcdf-pip", "python3-h5py-pip"}
INDIRECT_KEYS |= {"python3-pyvisa-py-pip"}
# The programs that sign surveys and make the certificate of the web page.
INDIRECT_KEYS |= {"openssh-client", "openssl"}
# The description of the robot, which the check of its configuration reads.
INDIRECT_KEYS |= {"gpr20_visualization"}
# Read by catkin, pip or a person in the sources.
BUILD_FILES = {"CHANGELOG.rst", "CMakeLists.txt", "README.md", "hatch_build.py", "package.xml"}
BUILD_FILES |= {"pyproject.toml", "setup.py"}
BUILD_FOLDERS = {"action", "env-hooks", "msg", "nodes", "src", "srv", "test"}


def python_files(folder):
    """Return the modules and the nodes of a package."""
    return [*folder.glob("src/**/*.py"), *(one for one in folder.glob("nodes/*") if one.is_file())]


@functools.lru_cache(maxsize=None)
def foreign_modules(name):
    """Return the top-level modules that a package imports from outside itself and Python."""
    found = set()
    for path in python_files(PACKAGES[name]):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(node.module.split(".")[0])
    return frozenset(found - set(standard_modules()) - {name})


def standard_modules():
    """Return the names of the standard library."""
    if sys.version_info < (3, 10):
        pytest.skip("this Python does not list its standard library")
    return sys.stdlib_module_names


def key_of(module):
    """Return the rosdep key of a module."""
    own = f"python3-{module}-pip"
    return own if own in OUR_KEYS else KEYS.get(module, module)


# A robot does not need it, and it is large: docs/ros.md says how to install it.
PROGRAMS_OF_PEOPLE = {"rviz"}


def depends(name, kinds="exec_depend|depend"):
    """Return the dependencies of a package."""
    text = (PACKAGES[name] / "package.xml").read_text()
    return set(re.findall(rf"<(?:{kinds})>(.+?)</", text))


def files_of(name):
    """Return the files of a package that git knows or would add, relative to its folder."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(
        command, cwd=PACKAGES[name], stdout=subprocess.PIPE, text=True, check=True
    ).stdout.splitlines()
    return [Path(one) for one in listed if (PACKAGES[name] / one).is_file()]


def cmake_of(name):
    """Return the CMakeLists.txt of a package."""
    return (PACKAGES[name] / "CMakeLists.txt").read_text()


@each_case("name", PACKAGES)
def test_a_package_depends_on_what_it_imports_and_on_nothing_else(name):
    imported = {key_of(one) for one in foreign_modules(name)}
    needed = imported - {key_of(one) for one in ROBOT_MODULES}
    assert needed <= depends(name), "add <exec_depend>...</exec_depend> to package.xml"
    if (PACKAGES[name] / "src").exists():
        spare = depends(name, "exec_depend") - imported - {"message_runtime"} - INDIRECT_KEYS
        launched = "".join(path.read_text() for path in PACKAGES[name].glob("**/*.launch"))
        assert {one for one in spare if one not in launched} == set()


@each_case("name", PACKAGES)
def test_launch_files_start_and_find_only_packages_that_are_depended_on(name):
    for path in PACKAGES[name].glob("**/*.launch"):
        named = set(re.findall(r'pkg="(\w+)"|\$\(find (\w+)\)|rosrun (\w+)', path.read_text()))
        used = {one for names in named for one in names if one} - {name} - PROGRAMS_OF_PEOPLE
        assert used <= depends(name)


def test_the_pip_packages_of_rosdep_are_those_of_the_requirements():
    used = set().union(*(depends(name) for name in PACKAGES))
    assert OUR_KEYS.keys() == {one for one in used if one.endswith("-pip")}
    pinned = (ROOT / "requirements/python3.11.txt").read_text().lower()
    for key, systems in OUR_KEYS.items():
        assert systems["debian"] == systems["ubuntu"], key
        (package,) = systems["debian"]["pip"]["packages"]
        assert re.search(rf"^{re.escape(package.lower())}==", pinned, re.MULTILINE), package


def test_a_clone_in_another_workspace_holds_each_package_once():
    packages = pytest.importorskip("catkin_pkg.packages")
    # As catkin_make looks for them, which also follows links; it refuses two of one name.
    found = packages.find_packages(str(ROOT), exclude_subspaces=True)
    assert sorted(one.name for one in found.values()) == sorted(PACKAGES)


def test_the_doctor_and_the_check_before_a_launch_know_what_the_nodes_import():
    # What gpr20_scikit_rf imports, it asks for itself.
    launched = set(PACKAGES) - {
        "gpr20_analysis",
        "gpr20_foreign_formats",
        "gpr20_scikit_rf",
        "gpr20_viewer",
    }
    imported = set().union(*(foreign_modules(name) for name in launched))
    ours = {one for one in imported - ROBOT_MODULES if key_of(one).endswith("-pip")}
    assert {*MODULES} == ours
    # The page, without which the robot works, needs the others.
    assert {*MODULES} - {*NEEDED} == {"tornado"}


@each_case("name", PACKAGES)
def test_every_file_of_a_package_is_installed(name):
    cmake = cmake_of(name)
    installed = " ".join(re.findall(r"(?:install|install_python|env_hooks)\(([^)]*)\)", cmake))
    words = set(installed.split())
    for path in files_of(name):
        top = path.parts[0]
        if len(path.parts) == 1 and top not in BUILD_FILES and not top.startswith("."):
            assert top in words, f"{path}: install(FILES {top} ...)"
        elif top == "nodes":
            assert str(path) in words, f"{path}: catkin_install_python(PROGRAMS {path} ...)"
        elif top == "env-hooks":
            assert path.stem in words, f"{path}: catkin_add_env_hooks({path.stem} ...)"
        elif len(path.parts) > 1 and top not in BUILD_FOLDERS:
            assert top in words, f"{path}: install(DIRECTORY {top} ...)"


# One version, maintainer, licence and address of all; pinned requirements.

MANIFESTS = [path / "package.xml" for path in PACKAGES.values()]
PINNED = {
    "3.8": ["nodes", "test", "system"],
    "3.11": ["nodes", "test", "lint", "docs", "robot"],
    "3.13": ["nodes", "test", "system"],
}


def test_every_package_has_version_people_licence_and_addresses_of_the_project():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    wanted = [*citation["contact"][0].values(), citation["license"]]
    wanted += [citation[key] for key in ("url", "repository-code") if key in citation]
    for path in [*MANIFESTS, *SOURCES.glob("*/pyproject.toml")]:
        text = path.read_text(encoding="utf-8")
        assert [one for one in wanted if one not in text] == [], path
    texts = [path.read_text() for path in [*MANIFESTS, *SOURCES.glob("*/src/*/__init__.py")]]
    version = r"""(?:<version>|^__version__ = "|^version: )([\w.]+)"""
    found = [re.findall(version, one, re.MULTILINE) for one in texts]
    assert len(found) > 10
    of_all = [str(citation["version"])]
    assert {*map(tuple, filter(None, found))} == {tuple(of_all)}, "change it by scripts/release.sh"
    assert f'current_version = "{of_all[0]}"' in (ROOT / "pyproject.toml").read_text()


def required(path):
    """Return the packages of a requirements file, as pip compares them."""
    found = re.findall(r"^([A-Za-z][\w.-]*)(?!.*python_version)", path.read_text(), re.MULTILINE)
    return {re.sub(r"[-_.]+", "-", one).lower() for one in found}


def test_every_listed_requirement_is_pinned():
    for python, lists in PINNED.items():
        pinned = required(ROOT / f"requirements/python{python}.txt")
        missing = {one for file in lists for one in required(ROOT / f"requirements/{file}.in")}
        assert missing <= pinned, "run scripts/requirements.sh"
