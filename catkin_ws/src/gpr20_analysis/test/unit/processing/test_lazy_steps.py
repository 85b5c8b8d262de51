"""Every step does to a lazy survey what it does to one in memory, and leaves it lazy."""

import dask.array
import numpy as np
import pytest
from fault_kit import raises_fault

from gpr20_analysis import faults
from gpr20_analysis.dataset import Quality
from gpr20_analysis.formats.common import Imported, as_dataset
from gpr20_analysis.processing.chain import apply_steps, step_from_text
from gpr20_analysis.processing.samples import fill_missing
from gpr20_analysis.processing.step_functions import FUNCTIONS

STEPS = [
    "coupling:reference=empty.nc",
    "background:method=median",
    "background:method=moving,width=5",
    "background:method=svd,rank=2",
    "band:start_hz=2e9,stop_hz=4e9",
    "delay:delay_s=3e-10",
    "time_zero",
    "pick_time_zero:arrival=surface,within_s=1e-9",
    "time_zero topography:permittivity=4",
    "dewow",
    "fk:along=x,least_deg=5,most_deg=60",
    "rpca",
    "fill",
    "polarization:rotation_deg=90",
    "time:window=none frequency",
    "time gain:method=agc",
    "time envelope",
    "window time_zero background:method=median combine time gain:method=agc",
]
NEED_ALL = ("svd", "fk", "rpca")
HOLES = [(0, 3, 2), (0, 4, 2), (1, 8, 6), (1, 0, 0)]


def noise(seed=6):
    values = np.random.default_rng(seed).standard_normal((2, 2, 9, 7, 41))
    return as_dataset(
        Imported(
            values[0] + 1j * values[1], [0.0, 90.0], np.arange(9) * 0.02, np.arange(7) * 0.02,
            np.full((2, 9, 7), 0.2), "noise", frequency_hz=np.linspace(1e9, 5e9, 41),
        )
    )  # fmt: skip


def with_holes():
    survey = noise()
    for hole in HOLES:
        survey.s21.values[hole] = np.nan
        survey.quality.values[hole] = int(Quality.MISSING)
        survey.height.values[hole] = np.nan
    return survey


def lazy(survey, rows=2):
    return survey.assign(s21=survey.s21.chunk({"polarization": 1, "y": rows}))


def processed(survey, text):
    steps = [step_from_text(one) for one in text.split()]
    return apply_steps(survey, steps, lambda path: noise(7))


def numbers_of(data):
    return data["a_scan" if "a_scan" in data else "s21"]


def assert_same(found, expected):
    assert isinstance(numbers_of(found).data, dask.array.Array)
    largest = float(abs(numbers_of(expected)).max())
    assert largest > 0.0
    np.testing.assert_allclose(
        numbers_of(found).values, numbers_of(expected).values, rtol=0.0, atol=1e-12 * largest
    )
    others = [name for name in expected.variables if name not in ("s21", "a_scan")]
    assert found[others].identical(expected[others])


@pytest.mark.parametrize("text", STEPS)
def test_a_step_does_the_same_to_a_lazy_survey_and_leaves_it_lazy(text):
    expected = processed(noise(), text)
    for rows in (2, 9):
        assert_same(processed(lazy(noise(), rows), text), expected)
    if not any(name in text for name in NEED_ALL):
        assert_same(processed(lazy(with_holes()), text), processed(with_holes(), text))


def test_every_step_is_tried():
    named = {part.partition(":")[0] for text in STEPS for part in text.split()}
    # It needs a model, and is tried in test_antenna_model.py.
    named.add("antenna")
    missing = set(FUNCTIONS) - named
    assert named == set(FUNCTIONS), f"add to STEPS of this file: {missing}"


def test_a_sample_without_neighbours_is_not_filled_in_a_lazy_survey_either():
    survey = noise()
    survey.s21.values[0, :2, :2] = np.nan
    survey.quality.values[0, :2, :2] = int(Quality.MISSING)
    with raises_fault(faults.SAMPLES_MISSING, "row 0, column 0 of polarization 0"):
        fill_missing(lazy(survey), most=0.5)
