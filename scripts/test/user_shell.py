"""A shell of a user's, in which nothing of ROS or this checkout was sourced, and its programs."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from pathlib import Path

from gpr20_survey.files.durable_files import writer_of

ROOT = Path(__file__).resolve().parents[2]
LIMIT_S = 600.0
SOURCED = (
    "ROS_",
    "ROSLISP",
    "GPR20_",
    "CMAKE_PREFIX",
    "PYTHON",
    "PKG_CONFIG",
    "LD_LIBRARY",
)

# The nodes of the simulated robot, the window left out.
NODES = ["x_axis/axis_driver", "y_axis/axis_driver", "z_axis/axis_driver", "height_sensor"]
NODES += ["simulator", "vna_acquisition", "vna_processing", "imaging", "main_control"]


def user_environment(data, **more):
    """Return the environment of such a shell, with a folder for surveys."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(SOURCED)}
    folders = [one for one in os.environ["PATH"].split(":") if not one.startswith(str(ROOT))]
    own = {"GPR20_DATA": str(data), "GPR20_STATE": f"{data}.state"}
    return {**kept, "PATH": ":".join(folders), **own, **more}


def printed_by(*command, status=0, folder=None, **more):
    """Run a program to its end, with more in the environment; return what it printed.

    What it leaves running is not waited for: a roslaunch that is ended while it starts nodes may
    leave its master behind.

    Args:
        command: The program and its arguments.
        status: How it must end; None: anyhow.
        folder: Where it runs.
        more: Of the environment, or all of it as `env`.
    """
    with tempfile.TemporaryFile("w+", errors="replace") as output:
        ended = subprocess.run(
            list(map(str, command)),
            cwd=folder,
            env=more.pop("env", {**os.environ, **more}),
            stdout=output,
            stderr=subprocess.STDOUT,
            check=False,
        )
        output.seek(0)
        printed = output.read()
    assert status in (None, ended.returncode), printed
    return printed


def unit_values(name, key):
    """Return the values of a key of a unit of debian/, in their order."""
    file = "gpr20.service" if name == "gpr20" else f"gpr20.{name}.service"
    text = (ROOT / "debian" / file).read_text("utf-8")
    return re.findall(rf"^{key}=(.*)$", text.replace("\\\n", " "), re.MULTILINE)


def has_bag(folder):
    """Return whether the bag of a survey that has ended is made, and named in its log."""
    return (folder / "survey.bag").exists() and writer_of(folder) is None
