"""The examples of the README."""

import doctest
from pathlib import Path

from simulated_axis import simulated_hardware

from gpr20_survey.axes.axis_id import AxisId

README = Path(__file__).parents[2] / "README.md"


def test_the_examples_of_the_readme_do_what_they_say(tmp_path):
    hardware = simulated_hardware(tmp_path, AxisId.X, time_scale=100.0)
    result = doctest.testfile(
        str(README), module_relative=False, globs={"hardware": hardware}, encoding="utf-8"
    )
    assert result.attempted > 0
    assert result.failed == 0
