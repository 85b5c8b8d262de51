"""A small survey of the simulated robot and a line over real ground, to try the commands on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from gpr20_analysis.formats.common import as_dataset, to_frequency
from gpr20_analysis.read import survey_attributes
from gpr20_common.message import Message

REAL_LINE_FILE = Path(__file__).with_name("real_line_charisma.npz")
# As fine as a record of 8 ns is [Hz].
BAND_HZ, POINTS = (0.5e9, 3.0e9), 21
# Not recorded, and assumed.
HEIGHT_M, TIME_ZERO_S = 0.01, 1.98e-9
NOTES = """\
332 traces over 14 reinforcing bars in concrete, 8.467 mm apart. GSSI, antenna "1.5/1.6GHz", impulse
of 512 samples over 8 ns.
Source: github.com/TFHRCFASTNDElab/CHARISMA (Federal Highway Administration), commit 8735da12,
Rebar mapping/data/Lab_specimen_data.DZT. Licence: CC0 1.0 Universal."""


def sample_survey() -> Path:
    """Return the path of the survey that is installed with this package, for `load_survey`.

    The simulated robot recorded it over the scene `imaging_targets.yaml` of gpr20_simulator:
    21 x 21 stops, rotations of 0 and 90 degrees, 101 frequencies. All data of it are SIMULATED.
    """
    return Path(__file__).with_name("survey.mcap")


def real_line() -> xr.Dataset:
    """Return a line that a GSSI radar measured over 14 reinforcing bars in concrete.

    Its spectra, from 0.5 to 3 GHz, are computed from the A-scans; their levels are relative. A
    permittivity of 6 gives depths near the published ones. The notes name source and licence.
    """
    with np.load(str(REAL_LINE_FILE)) as file:
        a_scans, time_s, x_m = (
            file[name].astype(np.float64) for name in ("a_scans", "time_s", "x_m")
        )
    line = as_dataset(
        a_scans[None, None],
        [0.0],
        np.zeros(1),
        np.linspace(x_m[0], x_m[-1], len(x_m)),
        np.full((1, 1, len(x_m)), HEIGHT_M),
        REAL_LINE_FILE.name,
        delay_s=time_s,
        simulated=False,
        notes=[
            Message(
                "not recorded, and assumed: antennas {height_mm:g} mm above the concrete, time "
                "zero {time_zero_ns:g} ns after the first sample; places along the line as "
                "recorded",
                height_mm=HEIGHT_M * 1e3,
                time_zero_ns=TIME_ZERO_S * 1e9,
            )
        ],
    )
    facts = {
        survey_attributes.NAME: "Real line: CHARISMA laboratory specimen (CC0)",
        survey_attributes.NOTES: NOTES,
        survey_attributes.ANTENNA_DELAY: TIME_ZERO_S,
    }
    return to_frequency(line, *BAND_HZ, POINTS).assign_attrs(facts)
