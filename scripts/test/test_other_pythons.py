"""The unit tests pass under the other Pythons that the code is written for.

scripts/test.sh makes a virtual environment for each of them that this machine has.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Sequence

import pytest
from pytest_gpr20.last_line import INSIDE
from pytest_gpr20.processes import run_limited
from pytest_gpr20.workspace import without_ros
from user_shell import ROOT

LIMIT_S = 900.0
EVERYTHING = sorted(path.parts[-3] for path in ROOT.glob("catkin_ws/src/*/test/unit"))
# As few as the examples of hypothesis: what is random is drawn under Debian's Python.
FEW_DRAWS = {
    "GPR20_DAMAGES": "10",
    "GPR20_MARKER_DRAWS": "4",
    "GPR20_NOISE_SURVEYS": "4",
    "GPR20_REPLAY_SEQUENCES": "30",
    "GPR20_ROUND_TRIPS": "2",
    "GPR20_SCENES": "2",
    "GPR20_SEEDS": "1",
    "GPR20_TOUCHES": "3000",
}


@dataclass(frozen=True)
class OtherPython:
    """A Python without ROS.

    Attributes:
        version: Its version.
        venv: Its virtual environment, a folder of the checkout.
        packages: The packages whose unit tests pass under it.
        left_out: Names of test files that are not run under it.
    """

    version: str
    venv: str
    packages: Sequence[str]
    left_out: Sequence[str] = ()

    @property
    def program(self) -> Path:
        """The interpreter."""
        return ROOT / self.venv / "bin/python"


# What these compute does not depend on the Python; Debian's runs them.
COMPUTED_ALIKE = [
    *("test_antenna_delay", "test_changed_description", "test_cluster", "test_image_grid"),
    *("test_image_noise", "test_kirchhoff_of_the_group", "test_many_surveys"),
    *("test_permittivity_estimate", "test_power_cuts", "test_reopening_killed"),
    *("test_report_in_own_language", "test_texts_of_figures", "test_varying_heights"),
]
# Long tests of the analysis that the Python of the robot repeats.
LONG_TESTS = [
    *("test_analyst_steps", "test_back_projection", "test_candidates"),
    *("test_damage_of_every_kind", "test_damaged_input", "test_flips_unseen"),
    *("test_focused_images", "test_image_of_damaged_surveys", "test_imaging_methods"),
    *("test_interrupted_command", "test_large_surveys", "test_lazy_steps", "test_notebook"),
    *("test_survey_report", "test_verify", "test_work_in_parts"),
]
ANALYSIS = ["gpr20_analysis", "gpr20_common", "gpr20_survey"]
# That of ROS Noetic, and a new one: the analysis also runs on other computers.
PYTHONS = [
    OtherPython("3.8", ".venv38", EVERYTHING, COMPUTED_ALIKE),
    OtherPython("3.13", ".venv313", ANALYSIS, [*COMPUTED_ALIKE, *LONG_TESTS]),
]
RUNS = [
    pytest.param(python, package, id=f"{python.version}-{package}")
    for python in PYTHONS
    for package in python.packages
]


@pytest.mark.takes(60)
# As a whole: in each of them some tests depend on real time.
@pytest.mark.real_time
@pytest.mark.parametrize("python, package", RUNS)
def test_the_unit_tests_pass_under(python, package, request, record_property):
    if not python.program.exists():
        pytest.skip(f"no Python {python.version} here ({python.venv})")
    environment = {name: value for name, value in os.environ.items() if "PYTEST" not in name}
    environment.update(FEW_DRAWS)
    cache = request.config.cache.mkdir(f"python{python.version}-{package}")
    options = ["-q", "-p", "no:rerunfailures", "-p", "no:xdist", "-o", f"cache_dir={cache}"]
    options.append("--hypothesis-profile=few_examples")
    tests = f"catkin_ws/src/{package}/test/unit"
    options += [f"--ignore={tests}/{name}.py" for name in python.left_out]
    if getattr(request.node, "execution_count", 1) > 1:
        options.append("--last-failed")
    ended = run_limited(
        [str(python.program), "-m", "pytest", *options, tests],
        without_ros(environment),
        LIMIT_S,
        ROOT,
    )
    record_property(INSIDE, ended.printed.splitlines()[-1])
    assert ended.status == 0, ended.printed
