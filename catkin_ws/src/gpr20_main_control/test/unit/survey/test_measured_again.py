"""A place measured again: known points and drift; what differs too much pauses the survey."""

from __future__ import annotations

import math
import threading

import numpy as np
import pytest
from case_kit import each_case
from cut_off_surveys import stored_trace
from hypothesis import given, settings
from hypothesis import strategies as st
from run_seed import draws
from survey_examples import AXES, PARAMETERS

from gpr20_main_control.errors import DRIFTED
from gpr20_main_control.mid.measured_again import (
    DriftLimits,
    KnownPoint,
    Repeated,
    drift_between,
    known_traces,
    s21_of,
)
from gpr20_main_control.mid.survey.survey_plan import plan_survey
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.plan.robot_description import RobotConfig
from gpr20_survey.plan.survey_parameters import SurveySettings
from gpr20_survey.plan.survey_state import SurveyState as State

HZ = np.linspace(600.0e6, 6.0e9, 501)


def echo(level, delay_s):
    return level * np.exp(-2j * np.pi * HZ * delay_s)


def hiss(random, level, count):
    parts = random.standard_normal((2, count)) * level / math.sqrt(2.0)
    return parts[0] + 1j * parts[1]


def echoes(seed):
    # A coupling and an echo: they have deep nulls.
    random = np.random.default_rng(seed)
    return sum(map(echo, random.uniform(0.01, 1.0, 2), random.uniform(0.5e-9, 8e-9, 2)))


@settings(max_examples=draws(50))
@given(
    st.integers(0, 2**31),
    st.floats(-20.0, 20.0),
    st.floats(-170.0, 170.0),
    st.floats(-120.0, -60.0),
)
def test_a_known_gain_and_phase_are_recovered_below_noise(seed, gain_db, phase_deg, noise):
    before = echoes(seed)
    level = math.sqrt(2.0 * np.mean(np.abs(before) ** 2)) * 10.0 ** (noise / 20.0)
    noisy = before + hiss(np.random.default_rng(seed + 1), level, 501)
    changed = noisy * 10.0 ** (gain_db / 20.0) * np.exp(1j * np.radians(phase_deg))
    found = drift_between(before, changed)
    assert found.amplitude_rms_db == pytest.approx(abs(gain_db), abs=0.05)
    assert found.phase_rms_deg == pytest.approx(abs(phase_deg), abs=0.3)


# A known point.


def traces_at(numbers, **changes):
    """Return traces of one stop at 0 and 90 deg whose S21 is a random vector by its number."""
    found = []
    for index, number in enumerate(numbers):
        noise = np.random.default_rng(number)
        values = {"s21_real": noise.normal(size=5), "s21_imag": noise.normal(size=5), **changes}
        found.append(stored_trace(index, z_coord_deg=90.0 * index, **values))
    return found


def compared(stored, again):
    return KnownPoint([Repeated(old, (new,)) for old, new in zip(stored, again)])


def test_antennas_that_are_turned_show_where_the_rotations_look_different():
    stored = traces_at([1, 2])
    assert not compared(stored, traces_at([1, 2])).turned
    turned = compared(stored, traces_at([2, 1]))
    assert turned.turned and not turned.agrees(100.0)
    # Over ground that looks the same at every rotation nothing can show.
    assert compared(traces_at([3, 3]), traces_at([3, 3])).agrees(-20.0)


def test_the_known_point_is_the_last_stop_that_was_measured_at_every_rotation():
    visits = [(10.0, 0.0), (10.0, 90.0), (20.0, 90.0), (20.0, 0.0), (30.0, 0.0)]
    recent = [
        stored_trace(index, x_coord_mm=x_mm, z_coord_deg=z_deg)
        for index, (x_mm, z_deg) in enumerate(visits)
    ]
    assert [one.index for one in known_traces(recent, 2)] == [2, 3]
    assert [one.index for one in known_traces(recent[:1], 2)] == [0]
    assert [one.index for one in known_traces(recent, 1)] == [4]


# The first stop, from time to time.

INTERVAL_S = 12.0
CONFIG = RobotConfig(AXES, simulated=True)
PLAN = plan_survey(PARAMETERS, CONFIG, SurveySettings(0.0, reference_interval_s=INTERVAL_S))
# The sweeps of a visit: two at each of two rotations.
SWEEPS = 4


@pytest.fixture
def visiting(make_bench):
    return make_bench(reference_interval_s=INTERVAL_S)


def louder(bench, factor=1.5):
    return lambda: setattr(bench.analyzer, "level", bench.analyzer.level * factor)


def visits(bench):
    return [one.values for one in bench.storage.notes if one.kind is Kind.DRIFT]


def marks(bench):
    return [(one["next_index"], one["exceeded"], one["accepted"]) for one in visits(bench)]


def test_a_survey_visits_its_first_stop_at_the_interval_and_at_its_end(visiting):
    assert len(PLAN.visits) > 2 and PLAN.visits[-1] == 24
    places = []
    visiting.analyzer.on_sweep = lambda: places.append(
        tuple(axis.coordinate for axis in visiting.axes)
    )
    visiting.start()
    visiting.complete()
    assert [one["next_index"] for one in visits(visiting)] == list(PLAN.visits)
    assert visiting.analyzer.sweeps == 24 + SWEEPS * len(PLAN.visits)
    for point in PLAN.points[:2]:
        place = (point.x_mm, point.y_mm, point.z_deg)
        assert places.count(place) == 1 + SWEEPS // 2 * len(PLAN.visits)
    for visit in visits(visiting):
        assert [one["index"] for one in visit["rotations"]] == [0, 1]
        for rotation in visit["rotations"]:
            assert rotation["amplitude_rms_db"] < 0.001 and rotation["phase_rms_deg"] < 1.0
            # Each of these sweeps differs from the one before by 1, of 10,000.
            assert rotation["noise_db"] == pytest.approx(-83.0, abs=0.1)
            assert rotation["height_difference_m"] == 0.0
    for interval_s in (3600.0, 0.0):
        unvisited = SurveySettings(0.0, reference_interval_s=interval_s)
        assert not plan_survey(PARAMETERS, CONFIG, unvisited).visits


def test_each_drift_that_is_too_large_pauses_and_is_accepted_as_it_is_after_resuming(visiting):
    first, second, *rest = PLAN.visits
    visiting.at_sweep(first - 1, louder(visiting))
    visiting.start()
    visiting.wait_for_fault(DRIFTED)
    assert visiting.wait_for(State.PAUSED).remaining_s > 0.0
    visiting.wait_for_visited(first)
    visiting.at_sweep(second + 2 * SWEEPS - 1, louder(visiting, 0.5))
    visiting.control.resume("")
    visiting.wait_for_visited(second)
    visiting.wait_for(State.PAUSED)
    visiting.control.resume("")
    visiting.complete()
    paused = [(one, *mark) for one in (first, second) for mark in ((True, False), (False, True))]
    assert marks(visiting) == paused + [(one, False, False) for one in rest]
    # What is stored is the drift since the start, whatever was accepted.
    drifts_db = [one["rotations"][1]["amplitude_rms_db"] for one in visits(visiting)]
    gains = (1.5, 1.5, *[0.75] * (len(rest) + 2))
    assert drifts_db == pytest.approx([abs(20.0 * math.log10(one)) for one in gains], abs=0.01)


@each_case("share, asks", [(0.9, False), (1.1, True)])
def test_a_drift_of_the_phase_alone_asks_the_operator_too(share, asks):
    settings = SurveySettings(0.0)
    (stored,) = traces_at([1])
    turned = s21_of(stored) * np.exp(1j * np.radians(share * settings.drift_limit_deg))
    (again,) = traces_at([1], s21_real=turned.real, s21_imag=turned.imag)
    visit = DriftLimits(settings).visit([Repeated(stored, (again, again))], 5, "")
    assert visit.exceeded is asks


def test_a_drift_at_the_end_warns_but_keeps_nobody_waiting(visiting):
    visiting.at_sweep(23 + SWEEPS * (len(PLAN.visits) - 1), louder(visiting))
    visiting.start()
    visiting.complete()
    assert visiting.board.status.remaining_s == 0.0
    assert marks(visiting)[-1] == (24, True, False)
    assert visiting.board.status.warning.fault_code == DRIFTED.code
    # A warning is not why a survey ended.
    assert visiting.storage.ends[-1].reason.fault_code == ""
    warnings = visiting.storage.reports[-1]["warnings"]
    assert [one["fault_code"] for one in warnings] == [DRIFTED.code]


def test_after_a_pause_as_long_as_the_interval_the_drift_is_looked_at_first(visiting):
    visiting.at_sweep(4, visiting.control.pause)
    visiting.start()
    visiting.wait_for(State.PAUSED)
    visiting.clock.wait_s(threading.Event(), 2.0 * INTERVAL_S)
    measured = visiting.board.status.visited_points
    visiting.control.resume("")
    visiting.complete()
    assert [one["next_index"] for one in visits(visiting)] == [measured, *PLAN.visits]
