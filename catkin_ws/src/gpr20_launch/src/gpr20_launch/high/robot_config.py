"""robot_config: create and check a robot's configuration, its signing key, its data folder."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import rosgraph

from gpr20_common.errors import Gpr20Error
from gpr20_common.low.clock import Clock
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import say
from gpr20_launch.high.check_launch import built_axes
from gpr20_launch.mid.launch_request import storage_parameters
from gpr20_launch.mid.robot_files import DEFAULT_FOLDER, Sections, read_configuration
from gpr20_launch.mid.signing_key import ensure_key
from gpr20_launch.mid.templates import templates
from gpr20_survey.folder.data_folder import DataFolder


def main() -> int:
    """Do what the command line asks; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="robot_config",
        description="Create or check the robot's configuration, make the key that signs its "
        "surveys, or accept the data folder as the one that is used from now on.",
    )
    parser.add_argument("action", choices=("create", "check", "key", "accept_data"))
    # As in the launch files, an empty variable means the default.
    default = os.environ.get("GPR20_CONFIG") or DEFAULT_FOLDER
    parser.add_argument("folder", nargs="?", default=default, type=Path)
    parser.add_argument("--data", default="", help="of accept_data: as data:= of the launch")
    given = parser.parse_args(rosgraph.myargv()[1:])
    folder = given.folder.expanduser().absolute()
    try:
        if given.action == "create":
            _create(folder)
        if given.action == "key":
            _make_key(folder)
        sections = read_configuration(folder, built_axes())
        if given.action == "accept_data":
            _accept_data(sections, given.data)
            return 0
    except Gpr20Error as error:
        remedy = [] if error.message.remedy is None else [f"-> {error.message.remedy}"]
        say(f"robot_config: {error}", *remedy, file=sys.stderr)
        return 1
    except OSError as error:
        say(f"robot_config: {folder}: {os_reason(error)}", file=sys.stderr)
        return 1
    say(f"{folder}: the configuration is correct")
    return 0


def _accept_data(sections: Sections, data: str) -> None:
    use = storage_parameters(sections, data).data_folder_use()
    identity = DataFolder(use, Clock()).accept()
    say(f"{use.path}: accepted as the data folder {identity}")


def _create(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in templates(built_axes()).items():
        path = folder / name
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(text)
        except FileExistsError:
            say(f"{path} exists and stays as it is")
        else:
            say(f"{path} created")


def _make_key(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for line in ensure_key(folder, read_configuration(folder, built_axes())):
        say(line)
