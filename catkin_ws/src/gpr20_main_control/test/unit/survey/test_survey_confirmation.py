"""A sweep is confirmed while the axes move on; only then its trace is stored."""

import threading

import pytest
from fake_robot import LIMIT_S, NODES, reports, warning_of

from gpr20_common.faults import PART_SILENT
from gpr20_common.message import Message
from gpr20_main_control.errors import DeviceError, UnconfirmedError
from gpr20_survey.faults import VNA_FAILED
from gpr20_survey.plan.survey_state import SurveyState as State

CHANGED = "the start frequency was changed by hand"
VNA = "vna_acquisition"


class Confirmations:
    """Confirms every sweep, but refuses some, and holds one until `release`."""

    def __init__(self):
        self.refused, self.held = {}, 0
        self.begun, self.released = threading.Event(), threading.Event()
        self.release = self.released.set

    def __call__(self, number):
        if number == self.held:
            self.begun.set()
            self.released.wait(LIMIT_S)
        if number in self.refused:
            raise self.refused[number]
        return ()


@pytest.fixture
def confirmations(bench):
    confirmations = bench.analyzer.on_confirm = Confirmations()
    yield confirmations
    confirmations.release()


def refusal(repeat=True):
    return UnconfirmedError(Message("{reason}", reason=CHANGED), repeat)


def numbers(bench):
    """The numbers of the stored sweeps."""
    return [round(sample.s21_real[0]) for sample in bench.storage.samples]


def test_the_next_move_does_not_wait_for_the_confirmation(bench, confirmations):
    confirmations.held = 1
    moved = threading.Event()
    begin_move = bench.z.begin_move
    bench.z.begin_move = lambda target: (begin_move(target), moved.set())
    bench.start()
    assert confirmations.begun.wait(LIMIT_S)
    # The second point is the other rotation at the first stop.
    assert moved.wait(LIMIT_S)
    assert bench.storage.samples == [] and bench.analyzer.sweeps == 1
    confirmations.release()
    bench.complete()


def test_the_trace_has_the_remarks_of_its_confirmation(bench):
    bench.analyzer.on_confirm = lambda number: ("the level is low",) if number == 3 else ()
    bench.analyzer.temperature_c = 40.75
    bench.start()
    bench.complete()
    assert [one.quality for one in bench.storage.samples[1:4]] == [(), ("the level is low",), ()]
    values = {(one.name, one.value, one.unit) for s in bench.storage.samples for one in s.aux}
    assert values == {("vna_temperature", 40.75, "degC")}


@pytest.mark.parametrize("number", [1, 24])
def test_a_sweep_that_is_not_confirmed_is_taken_again_at_its_own_place(
    bench, confirmations, number
):
    places = []
    bench.analyzer.on_sweep = lambda: places.append(
        (bench.x.coordinate, bench.y.coordinate, bench.z.coordinate)
    )
    confirmations.refused[number] = refusal()
    bench.start()
    bench.complete()
    assert numbers(bench) == [*range(1, number), *range(number + 1, 26)]
    again = bench.storage.samples[number - 1]
    assert places[number] == places[number - 1]
    assert places[number] == (again.x_coord_mm, again.y_coord_mm, again.z_coord_deg)
    (remark,) = again.quality
    assert "measured again" in remark and CHANGED in remark
    (warning,) = bench.storage.reports[-1]["warnings"]
    assert reports(warning_of(warning), VNA_FAILED, number - 1, CHANGED)
    assert State.PAUSED.name not in bench.states


@pytest.mark.parametrize(
    "refused, error, swept",
    [
        ((4, 5, 6), refusal(), 6),
        ((4,), refusal(repeat=False), 4),
        ((4,), DeviceError(Message("{reason}", reason=CHANGED)), 4),
    ],
)
def test_a_point_that_is_not_confirmed_after_its_repetitions_pauses_the_survey(
    bench, confirmations, refused, error, swept
):
    confirmations.refused.update(dict.fromkeys(refused, error))
    bench.start()
    assert CHANGED in str(bench.wait_for(State.PAUSED).message)
    bench.wait_for_visited(3)
    assert numbers(bench) == [1, 2, 3] and bench.analyzer.sweeps == swept
    bench.resume_to_the_end()
    assert numbers(bench) == [1, 2, 3, *range(swept + 1, swept + 22)]


def test_an_analyzer_that_is_lost_while_it_confirms_costs_one_more_sweep(bench, confirmations):
    confirmations.held = 3
    bench.start()
    assert confirmations.begun.wait(LIMIT_S)
    bench.nodes.note_silent(VNA)
    bench.wait_for_fault(PART_SILENT.as_warning(), NODES[VNA])
    confirmations.release()
    bench.nodes.note_alive(VNA, 2)
    bench.complete()
    assert numbers(bench) == [1, 2, *range(4, 26)]
    assert State.PAUSED.name not in bench.states
