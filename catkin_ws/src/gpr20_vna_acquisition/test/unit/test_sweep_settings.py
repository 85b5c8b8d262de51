"""Only sweeps that the instrument can make, on an exact frequency grid."""

from __future__ import annotations

import math

import numpy as np
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st

from gpr20_common import faults as common_faults
from gpr20_common.mid.records import record_from
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition import faults
from gpr20_vna_acquisition.mid.settings import check_frequencies
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters


def test_accepts_the_whole_range():
    for points in (2, 4000):
        VnaParameters().check_sweep(SweepSettings(5e3, 6e9, points))


def test_refuses_naming_value_and_limit():
    for start, stop, points, shown in [
        (0.0, 6e9, 501, ("0 Hz", 5000)),
        (4999.0, 6e9, 501, (5000, "6000000000 Hz")),
        (-1e9, 6e9, 501, ("-1000000000 Hz", "6000000000 Hz")),
        (math.nan, 6e9, 501, ("nan",)),
        (1e9, math.inf, 501, ("inf",)),
        (1e9, 6.1e9, 501, ("6100000000 Hz", "6000000000 Hz")),
        (2e9, 1e9, 501, ("2000000000 Hz", "1000000000 Hz")),
        (1e9, 1e9, 501, ("1000000000 Hz",)),
        (1e9, 2e9, 0, (0, 2, 4000)),
        (1e9, 2e9, 1, (1, 2, 4000)),
        (1e9, 2e9, 4001, (4001, 4000)),
        (1e9, 2e9, -5, (-5, 2)),
    ]:
        with raises_fault(common_faults.NOT_ALLOWED, *shown):
            print(start, stop, points)
            VnaParameters().check_sweep(SweepSettings(start, stop, points))


@given(st.integers(2, 4000), st.integers(5000, 5_999_000_000))
def test_grid_is_exact_where_single_precision_is_not(points, start_hz):
    grid_hz = SweepSettings(float(start_hz), 6e9, points).frequencies_hz()
    assert grid_hz.dtype == np.float64 and len(grid_hz) == points
    assert grid_hz[0] == start_hz and grid_hz[-1] == 6e9
    assert (np.diff(grid_hz) > 0).all()
    middle = points // 2
    exact = start_hz + middle * (6_000_000_000 - start_hz) / (points - 1)
    assert abs(grid_hz[middle] - exact) < 1e-5


def test_accepts_the_grid_in_single_precision():
    sweep = SweepSettings(600e6, 6e9, 501)
    check_frequencies(sweep.frequencies_hz().astype(np.float32).astype(np.float64), sweep)


def test_refuses_another_grid():
    grids_hz = [
        SweepSettings(600e6, 5.9e9, 501).frequencies_hz(),
        SweepSettings(600.002e6, 6e9, 501).frequencies_hz(),
        SweepSettings(600e6, 6.00001e9, 501).frequencies_hz(),
        np.geomspace(600e6, 6e9, 501),
    ]
    for grid_hz in grids_hz:
        with raises_fault(faults.NOT_LINEAR):
            print(grid_hz)
            check_frequencies(grid_hz, SweepSettings(600e6, 6e9, 501))


def test_parameters_that_make_no_sense_are_named():
    for name, value in [
        ("answer_timeout_s", 0.0),
        ("settle_s", math.nan),
        ("attempts", 0),
        ("vxi11_port", 70000),
        ("transfer_format", "REAL,64"),
        ("seconds_per_point", -1.0),
        ("max_frequency_hz", 1.0),
        ("min_level_db", math.nan),
        ("min_level_db", 0.0),
        ("max_level_db", math.inf),
        ("same_points", 1),
        ("duration_tolerance_s", -0.1),
        ("connect_timeout_s", 1e300),
        ("poll_interval_s", 1e-300),
        ("link_check_s", 3601.0),
        ("maker", ""),
        ("model", " "),
        ("accepted_calibrations", (1, 6)),
    ]:
        with raises_fault((common_faults.NOT_ALLOWED, common_faults.CONFIGURATION), name):
            print(name, record_from(VnaParameters, {name: value}, "vna_acquisition"))
