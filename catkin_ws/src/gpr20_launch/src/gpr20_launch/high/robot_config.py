"""robot_config: create, import and check a robot's configuration, its signing key, its data."""

from __future__ import annotations

import argparse
import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Callable, Dict, Mapping

import rosgraph

from gpr20_common.errors import ConfigurationError, Gpr20Error, os_reason
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.low.yaml_file import read_yaml, robot_folder
from gpr20_common.message import verbatim
from gpr20_common.terminal_text import printable, say
from gpr20_launch.faults import NOT_CHECKED
from gpr20_launch.high.check_launch import built_axes, message_field, say_problems
from gpr20_launch.mid.old_launch import old_robot
from gpr20_launch.mid.robot_check import WIRING_FILE, check_robot
from gpr20_launch.mid.robot_files import PARTS, REAL, ROBOT, ROBOTS, SURVEY, Reading, Use
from gpr20_launch.mid.written_files import ensure_key, templates
from gpr20_survey.folder.data_folder import DataFolder


def main() -> int:
    """Do what the command line asks; return the exit status."""
    given = _parser().parse_args(rosgraph.myargv()[1:])
    folder = given.folder.expanduser().absolute()
    try:
        return int(given.act(folder, given))
    except Gpr20Error as error:
        remedy = [] if error.message.remedy is None else [f"-> {error.message.remedy}"]
        say(f"robot_config: {error}", *remedy, file=sys.stderr)
    except OSError as error:
        say(f"robot_config: {folder}: {os_reason(error)}", file=sys.stderr)
    return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="robot_config", description="Create, import and check the robot's configuration."
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION")
    actions.required = True

    def add(name: str, act: Callable[..., int], text: str) -> argparse.ArgumentParser:
        one = actions.add_parser(name, help=text, description=text)
        one.set_defaults(act=act)
        return one

    create = add("create", _create, "write commented files that show the defaults")
    create.add_argument("--profile", choices=sorted(_profiles()), help="values of a known robot")
    old = add("import", _import, "write files from a launch file of the original software")
    old.add_argument("launch", type=Path, help="the launch file of the robot's computer")
    check = add("check", _check, "say what is wrong or doubtful; change nothing")
    check.add_argument("--json", action="store_true", help="for programs")
    check.add_argument("--robot", choices=ROBOTS, default=REAL)
    check.add_argument("--part", choices=PARTS, default=SURVEY)
    add("key", _make_key, "make the key that signs surveys")
    accept = add("accept_data", _accept_data, "accept the data folder that is there from now on")
    for one in (check, accept):
        one.add_argument("--data", default="", help="as data:= of the launch")
    for one in actions.choices.values():
        one.add_argument("folder", nargs="?", default=robot_folder(os.environ), type=_named)
    return parser


def _named(text: str) -> Path:
    # An empty text, such as of a variable that is not set, is not the current folder.
    if not text.strip():
        raise argparse.ArgumentTypeError("name a folder")
    return Path(text)


def _check(folder: Path, given: argparse.Namespace) -> int:
    use = Use(os.environ, given.data, given.robot == REAL, given.part)
    found = check_robot(Reading(folder, built_axes()), use, message_field)
    if given.json:
        print(json.dumps([one.record() for one in found]))  # noqa: T201
    elif found:
        say_problems(found, sys.stdout)
    else:
        say(f"{folder}: the configuration is correct")
    return int(any(one.refuses for one in found))


def _create(folder: Path, given: argparse.Namespace) -> int:
    files = () if given.profile is None else _profiles()[given.profile].glob("*.yaml")
    return _fill(folder, {path.name: path.read_text(encoding="utf-8") for path in files})


def _import(folder: Path, given: argparse.Namespace) -> int:
    robot = old_robot(given.launch, read_yaml(built_axes()))
    status = _fill(folder, robot.texts)
    say("not found out:", *(f"  {one}" for one in robot.unread or ["nothing"]))
    say("without a counterpart:", *(f"  {one}" for one in robot.values or ["nothing"]))
    return int(status or bool(robot.unread))


def _fill(folder: Path, own: Mapping[str, str]) -> int:
    # They would take no effect beside those that are there.
    there = [name for name in sorted(own) if os.path.lexists(str(folder / name))]
    if there:
        text = (
            f"{printable(folder)} has {', '.join(there)} already, which stay as they are; give an "
            "empty folder, compare its files with these, and copy what is right"
        )
        raise ConfigurationError(verbatim(text), fault=NOT_ALLOWED)
    folder.mkdir(parents=True, exist_ok=True)
    texts, said = {**templates(read_yaml(built_axes())), **own}, []
    # What refuses a launch comes first: whatever interrupts this, no robot starts unchecked.
    for name in sorted(texts, key=lambda name: (name != WIRING_FILE, name)):
        path = folder / name
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(texts[name])
            said.append(f"{path} created")
        except FileExistsError:
            said.append(f"{path} exists and stays as it is")
    say(*said)
    reading = Reading(folder, built_axes())
    found = check_robot(reading, Use(os.environ, part=ROBOT), message_field)
    say_problems(found, sys.stdout)
    # What a person must check by hand is no failure of this command.
    return int(any(one.refuses and one.message.cause != NOT_CHECKED for one in found))


def _profiles() -> Dict[str, Path]:
    return {path.name: path for path in (built_axes().parent / "profiles").iterdir()}


def _correct(folder: Path) -> Reading:
    reading = Reading(folder, built_axes())
    if reading.problems:
        raise ConfigurationError(reading.problems[0].message)
    return reading


def _make_key(folder: Path, _given: argparse.Namespace) -> int:
    folder.mkdir(parents=True, exist_ok=True)
    say(*ensure_key(_correct(folder)))
    return 0


def _accept_data(folder: Path, given: argparse.Namespace) -> int:
    storage = _correct(folder).record("storage")
    use = replace(storage, data=given.data.strip() or storage.data).data_folder_use()
    identity = DataFolder(use).accept()
    say(f"{use.path}: accepted as the data folder {identity}")
    return 0
