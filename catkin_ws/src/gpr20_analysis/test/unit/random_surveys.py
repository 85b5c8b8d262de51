"""Surveys of random size, place and completeness, for round trips through files."""

import numpy as np

from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.common import as_dataset


def noise_survey(seed, rows=9, columns=7):
    """Return a survey of noise alone, of two polarizations."""
    values = np.random.default_rng(seed).standard_normal((2, 2, rows, columns, 41))
    return as_dataset(
        values[0] + 1j * values[1], [0.0, 90.0], np.arange(rows) * 0.02,
        np.arange(columns) * 0.02, np.full((2, rows, columns), 0.2), "noise",
        frequency_hz=np.linspace(1e9, 5e9, 41),
    )  # fmt: skip


def random_survey(seed, one_polarization=False):
    """Return a survey on an even grid with holes; whole rows at the edges may be missing."""
    rng = np.random.default_rng(seed)
    columns, rows, points = rng.integers(2, 6), rng.integers(2, 6), rng.integers(3, 40)
    turns = [0.0] if one_polarization else [[0.0], [90.0], [0.0, 90.0]][rng.integers(3)]
    start_mm, step_mm = rng.uniform(0.0, 300.0, 2).round(2), rng.uniform(1.0, 40.0, 2).round(2)
    shape = (len(turns), rows, columns)
    values = rng.standard_normal((2, *shape, points)) * 10.0 ** rng.uniform(-6, 0)
    height_m = rng.uniform(0.05, 0.4, shape).round(5)
    missing = rng.random(shape) < 0.15
    if rng.random() < 0.5:
        missing[:, -1, :] = True  # an edge, which no name of a file shows
    missing[0, 0, 0] = False
    s21 = values[0] + 1j * values[1]
    s21[missing] = np.nan
    height_m[missing] = np.nan
    start_hz, step_hz = rng.integers(300, 900) * 1e6, rng.integers(5, 200) * 1e6
    survey = as_dataset(
        s21,
        turns,
        (start_mm[1] + step_mm[1] * np.arange(rows)) / 1000.0,
        (start_mm[0] + step_mm[0] * np.arange(columns)) / 1000.0,
        height_m,
        "random",
        frequency_hz=start_hz + step_hz * np.arange(points),
        simulated=bool(rng.integers(2)),
    )
    survey = survey.assign(index=(survey.index.dims, np.arange(missing.size).reshape(shape)))
    assert ((survey.quality.values & int(Quality.MISSING)) != 0).tolist() == missing.tolist()
    return survey.assign_attrs(survey_id=f"survey-{seed}", antenna_delay_s=0.25e-9)
