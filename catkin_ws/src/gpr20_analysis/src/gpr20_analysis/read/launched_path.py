"""The path of a survey as a user gave it to roslaunch."""

from __future__ import annotations

import os
from pathlib import Path
from typing import List, Mapping

# Set by replay.launch: in an argument of a node roslaunch would split a path at its spaces.
SURVEY = "GPR20_REPLAY_SURVEY"


def with_survey(arguments: List[str], environment: Mapping[str, str]) -> List[str]:
    """Return the arguments of the replay with the survey that the launch file names, if any."""
    survey = environment.get(SURVEY, "")
    if not survey:
        return arguments
    return [*arguments, "--", str(_launcher_folder() / Path(survey).expanduser())]


def _launcher_folder() -> Path:
    # roslaunch starts nodes in ~/.ros; it itself is still where the user called it.
    return Path(os.readlink(f"/proc/{os.getppid()}/cwd"))
