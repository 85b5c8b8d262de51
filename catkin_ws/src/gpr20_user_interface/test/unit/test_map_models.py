import numpy as np
import pytest
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from view_kit import SURVEY, TRAVEL, description, make_grid

from gpr20_common.message import verbatim
from gpr20_operator import faults
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.coverage import (
    CoverageRuns,
    MapModel,
    StopState,
    coverage_of_stored,
)
from gpr20_operator.ground.geometry import (
    LEAST_ABOVE,
    MOST_ABOVE,
    Area,
    divided,
    shown_area,
    survey_area,
)
from gpr20_operator.ground.grid import Stop, grid_from_description
from gpr20_survey.plan.coverage import Coverage, SampleState
from gpr20_survey.plan.survey_plan import survey_points

VERDICT = verbatim("INCOMPLETE: some are missing")
STATES = st.sampled_from(list(SampleState))


def runs_of(coverage, survey_id=SURVEY):
    starts = tuple(start for start, _state in coverage.runs())
    states = tuple(int(state) for _start, state in coverage.runs())
    planned = len(coverage.states)
    return CoverageRuns(survey_id, planned, starts, states, coverage.reasons, VERDICT)


@given(
    st.integers(3, 9),
    st.integers(3, 9),
    st.sampled_from([(0.0,), (0.0, 90.0), (-90.0, 0.0, 90.0)]),
    st.booleans(),
)
def test_every_place_of_the_plan_is_where_main_control_goes(columns, rows, rotations, reverse):
    ends = {"x_start_mm": 200.0, "x_stop_mm": 100.0} if reverse else {}
    grid = make_grid(columns, rows, rotations, **ends)
    points = survey_points(grid.plan[0], TRAVEL)
    assert grid.planned == len(points)
    indices = np.array([one.index for one in points])
    positions = np.array([(one.x_mm, one.y_mm, one.z_deg) for one in points])
    assert grid.holds(grid.cells(indices), positions).all()
    assert [grid.index(grid.cell(one.index)) for one in points] == indices.tolist()


@given(st.lists(STATES, min_size=1, max_size=60))
def test_coverage_comes_through_as_it_was(states):
    coverage = Coverage(len(states))
    for index, state in enumerate(states):
        if state is SampleState.FAILED:
            coverage.note_failed(index, verbatim("the VNA: no answer"))
        elif state is not SampleState.NOT_VISITED:
            coverage.note_stored(index)
            if state is SampleState.REMEASURED:
                coverage.note_remeasured(index)
    runs = runs_of(coverage)
    assert runs.trace_states().tolist() == states
    assert runs.failures == coverage.reasons


@given(st.integers(1, 50), st.sets(st.integers(0, 60)))
def test_coverage_of_a_past_survey_has_exactly_the_stored_traces(planned, stored):
    states = coverage_of_stored(SURVEY, planned, stored).trace_states()
    assert set(np.flatnonzero(states)) == {index for index in stored if index < planned}


def test_contradicting_coverage_is_refused():
    for planned, starts, states in (
        (5, (), ()),
        (5, (1,), (0,)),
        (5, (0, 0), (0, 1)),
        (5, (0, 5), (0, 1)),
        (5, (0, 3, 2), (0, 1, 0)),
        (5, (0, 3), (0,)),
        (5, (0,), (4,)),
        (2**32 - 1, (0,), (0,)),
    ):
        with pytest.raises(SurveyNotReadableError):
            CoverageRuns(SURVEY, planned, starts, states).trace_states()


def filled_map(stored=(), failed=()):
    grid = make_grid()
    coverage = Coverage(grid.planned, stored)
    for index in failed:
        coverage.note_failed(index, verbatim(f"reason {index}"))
    model = MapModel()
    model.set_grid(grid)
    model.set_coverage(runs_of(coverage))
    return model


def test_a_stop_is_done_only_with_all_its_polarizations():
    # 5 columns with 2 polarizations: trace 10 is the first of row 1, at the last column.
    model = filled_map(stored=[0, 1, 2, 4, 10, 11], failed=[5])
    states = [model.state_at(Stop(row, column)) for row in (0, 1) for column in range(5)]
    missing = StopState.MISSING
    first_row = [StopState.DONE, StopState.PARTLY, StopState.FAILED, missing, missing]
    assert states == [*first_row, *[missing] * 4, StopState.DONE]
    assert model.reasons_at(Stop(0, 2)) == (verbatim("reason 5"),)
    assert model.counts() == {
        StopState.DONE: 2,
        StopState.PARTLY: 1,
        StopState.MISSING: 16,
        StopState.FAILED: 1,
    }
    assert model.verdict == VERDICT


def test_the_target_is_the_current_stop():
    model = filled_map()
    for place, stop in (
        ((100.0, 50.0), Stop(0, 0)),
        ((126.0, 71.0), Stop(1, 1)),
        ((213.0, 50.0), None),
        ((float("nan"), 50.0), None),
        ((-1.0, -1.0), None),
        (None, None),
    ):
        model.set_target(place)
        assert model.current == stop


def test_coverage_of_another_survey_is_not_shown_on_this_plan():
    model = filled_map(stored=[0, 1])
    model.set_grid(make_grid(survey_id="7c9e6679-7425-40de-944b-e07fc1f90ae7"))
    assert model.stop_states is None
    assert model.counts() is None
    assert model.verdict is None


def test_coverage_may_come_before_the_plan():
    model = MapModel()
    model.set_coverage(runs_of(Coverage(40, [0, 1])))
    assert model.stop_states is None
    model.set_grid(make_grid())
    assert model.counts()[StopState.DONE] == 1


def test_a_plan_of_another_size_is_refused():
    model = MapModel()
    model.set_grid(make_grid())
    with raises_fault(faults.COVERAGE_WRONG, 41):
        model.set_coverage(runs_of(Coverage(41)))
    assert model.stop_states is None


def test_the_plan_is_read_from_survey_json():
    grid = grid_from_description(description())
    assert (grid.shape, grid.planned, grid.simulated) == ((4, 5), 40, True)
    assert grid.holds(grid.cells(np.array([0])), np.array([[100.0, 50.0, 0.0]])).all()
    # Data of unknown origin count as simulated.
    assert grid_from_description(description(simulated="no")).simulated
    assert not grid_from_description(description(simulated=False)).simulated


def test_what_describes_no_survey_is_refused():
    wrong = [description(parameters={}), description(axes=None), "x" * 3_000_000, "[" * 100_000]
    for text in ("", "[]", "{}", *wrong):
        with pytest.raises(SurveyNotReadableError):
            grid_from_description(text)


@given(
    st.floats(1.0, 900.0), st.floats(1.0, 900.0), st.integers(200, 1200), st.integers(100, 700)
)  # fmt: skip
def test_the_pictures_share_a_room_so_that_none_is_too_small(width_mm, height_mm, width, height):
    beside, above_px = divided(width_mm, height_mm, width, height)
    along_px = width if beside else height
    assert LEAST_ABOVE * along_px - 1 <= above_px <= MOST_ABOVE * along_px + 1
    room = (above_px, height) if beside else (width, above_px)
    scale = min(room[0] / width_mm, room[1] / height_mm)
    assert scale * width_mm <= room[0] + 1e-6 and scale * height_mm <= room[1] + 1e-6


def test_a_survey_is_shown_with_those_around_it_unless_it_would_be_too_small():
    own = Area(100.0, 200.0, 50.0, 150.0)
    assert shown_area(own, [Area(80.0, 120.0, 50.0, 60.0)]) == Area(80.0, 200.0, 50.0, 150.0)
    assert shown_area(own, [Area(-900.0, 900.0, 0.0, 600.0)]) == own.grown(25.0)
    line = survey_area(np.array([10.0, 20.0, 30.0]), np.array([5.0]))
    assert (line.width_mm, line.height_mm) == (30.0, 2.0)
