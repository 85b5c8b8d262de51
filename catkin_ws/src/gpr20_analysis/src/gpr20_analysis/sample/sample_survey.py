"""Where the sample survey is."""

from __future__ import annotations

from pathlib import Path


def sample_survey() -> Path:
    """Return the path of the survey that is installed with this package.

    The simulated robot recorded it over the scene `imaging_targets.yaml` of gpr20_simulator:
    21 x 21 stops, rotations of 0 and 90 degrees, 101 frequencies. All data of it are SIMULATED.

    Returns:
        Path of an MCAP file for `load_survey`.
    """
    return Path(__file__).with_name("survey.mcap")
