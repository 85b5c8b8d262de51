"""What is measured of a plan, and where: the same as main control has it."""

import numpy as np
import pytest
from case_kit import each_case
from fault_kit import raises_fault
from hypothesis import given
from hypothesis import strategies as st
from view_kit import PAST, SURVEY, TRAVEL, description, make_grid

from gpr20_common.faults import VERSIONS_DIFFER
from gpr20_common.message import verbatim
from gpr20_main_control.mid.survey.survey_status import Coverage
from gpr20_operator.errors import SurveyNotReadableError
from gpr20_operator.ground.coverage import CoverageRuns, MapModel, StopState, coverage_of_stored
from gpr20_operator.ground.grid import Stop, grid_from_description
from gpr20_survey.plan.survey_points import survey_points
from gpr20_survey.plan.survey_state import SampleState

STATES = st.sampled_from(list(SampleState))


def runs_of(coverage, survey_id=SURVEY):
    starts = tuple(start for start, _state in coverage.runs())
    states = tuple(int(state) for _start, state in coverage.runs())
    planned = len(coverage.states)
    return CoverageRuns(survey_id, planned, starts, states, coverage.reasons)


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
    cells = grid.cells(indices)
    assert grid.holds(cells, positions).all()
    found = [grid.index(Stop(row, column), number) for row, column, number in zip(*cells)]
    assert found == indices.tolist()


@given(st.lists(STATES, min_size=1, max_size=60))
def test_coverage_comes_through_as_it_was(states):
    coverage = Coverage(len(states))
    for index, state in enumerate(states):
        if state is SampleState.FAILED:
            coverage.note_failed(index, verbatim("the VNA: no answer"))
        elif state is not SampleState.NOT_VISITED:
            coverage.note_stored(index)
    runs = runs_of(coverage)
    assert runs.trace_states().tolist() == states
    assert runs.failures == coverage.reasons
    # Of a past survey only what is stored is known.
    stored = {index for index, state in enumerate(states) if state is not SampleState.NOT_VISITED}
    past = coverage_of_stored(SURVEY, len(states), {*stored, len(states)})
    assert set(np.flatnonzero(past.trace_states())) == stored


@each_case(
    "planned,starts,states",
    [
        *((5, (), ()), (5, (1,), (0,)), (5, (0, 0), (0, 1)), (5, (0, 5), (0, 1))),
        *((5, (0, 3, 2), (0, 1, 0)), (5, (0, 3), (0,)), (5, (0,), (4,)), (2**32 - 1, (0,), (0,))),
    ],
)
def test_contradicting_coverage_is_refused(planned, starts, states):
    with pytest.raises(SurveyNotReadableError):
        CoverageRuns(SURVEY, planned, starts, states).trace_states()


def test_a_stop_is_done_only_with_all_its_polarizations():
    # 5 columns with 2 polarizations: trace 10 is the first of row 1, at the last column.
    coverage = Coverage(40, [0, 1, 2, 4, 10, 11])
    coverage.note_failed(5, verbatim("reason 5"))
    model = MapModel()
    model.set_grid(make_grid())
    model.set_coverage(runs_of(coverage))
    states = model.stop_states[:2].ravel().tolist()
    missing = StopState.MISSING
    first_row = [StopState.DONE, StopState.PARTLY, StopState.FAILED, missing, missing]
    assert states == [*first_row, *[missing] * 4, StopState.DONE]
    assert model.reasons_at(Stop(0, 2)) == (verbatim("reason 5"),)
    assert model.counts()[StopState.DONE] == 2
    for place, stop in (((126.0, 71.0), Stop(1, 1)), ((213.0, 50.0), None), (None, None)):
        model.set_target(place)
        assert model.current == stop


def test_coverage_is_shown_on_the_plan_of_its_survey_whichever_comes_first():
    model = MapModel()
    model.set_coverage(runs_of(Coverage(40, [0, 1])))
    assert model.stop_states is None
    model.set_grid(make_grid())
    assert model.counts()[StopState.DONE] == 1
    model.set_grid(make_grid(survey_id=PAST))
    assert (model.stop_states, model.counts()) == (None, None)
    model.set_grid(make_grid())
    with raises_fault(VERSIONS_DIFFER, 41):
        model.set_coverage(runs_of(Coverage(41)))


def test_the_plan_is_read_from_survey_json():
    grid = grid_from_description(description(simulated=False))
    assert (grid.shape, grid.planned, grid.simulated) == ((4, 5), 40, False)
    # Data of unknown origin count as simulated.
    assert grid_from_description(description(simulated="no")).simulated
    for text in ("", "[]", "{}", description(axes=None), "x" * 3_000_000, "[" * 100_000):
        with pytest.raises(SurveyNotReadableError):
            grid_from_description(text)
