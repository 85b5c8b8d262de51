"""What a package imports it depends on, what it reads is installed; versions agree."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path

import yaml
from case_kit import each_case
from user_shell import ROOT

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
# Read by catkin, pip or a person in the sources.
BUILD_FILES = {"CHANGELOG.rst", "CMakeLists.txt", "README.md", "hatch_build.py", "package.xml"}
BUILD_FILES |= {"pyproject.toml", "setup.py"}
BUILD_FOLDERS = {"action", "env-hooks", "msg", "nodes", "src", "srv", "test"}


@functools.lru_cache(maxsize=None)
def foreign_modules(name):
    """Return the top-level modules that a package imports from outside itself and Python."""
    folder, found = PACKAGES[name], set()
    for path in (*folder.glob("src/**/*.py"), *filter(Path.is_file, folder.glob("nodes/*"))):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(node.module.split(".")[0])
    return frozenset(found - sys.stdlib_module_names - {name})


def key_of(module):
    """Return the rosdep key of a module."""
    own = f"python3-{module}-pip"
    return own if own in OUR_KEYS else KEYS.get(module, module)


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


@each_case("name", PACKAGES)
def test_a_package_depends_on_what_it_imports(name):
    imported = {key_of(one) for one in foreign_modules(name)}
    needed = imported - {key_of(one) for one in ROBOT_MODULES}
    assert needed <= depends(name), "add <exec_depend>...</exec_depend> to package.xml"


@each_case("name", PACKAGES)
def test_every_file_of_a_package_is_installed(name):
    cmake = (PACKAGES[name] / "CMakeLists.txt").read_text()
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


# One version, maintainer, licence and address of all.

MANIFESTS = [path / "package.xml" for path in PACKAGES.values()]


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
