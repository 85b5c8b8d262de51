"""Random failures, pauses and stops: each sample is stored once, and only if it was confirmed.

GPR20_INTERLEAVINGS sets the number of surveys; a failure names its seed.
"""

import os
import random
import threading
import time

from fake_robot import LIMIT_S, NODES, Bench, FakeAnalyzer, FakeAxis
from strict_storage import StrictStorage, folder_of
from survey_examples import PARAMETERS, TRAVEL

from gpr20_common.message import Message, verbatim
from gpr20_main_control.errors import DeviceError, RequestRefusedError, UnconfirmedError
from gpr20_main_control.mid.devices.robot import MoveOutcome, SweepConfirmation
from gpr20_survey.plan.survey_plan import survey_points
from gpr20_survey.plan.survey_state import SurveyState as State

DRAWS = int(os.environ.get("GPR20_INTERLEAVINGS", "25"))
PLAN = survey_points(PARAMETERS, TRAVEL)


class Chance:
    """Draws what happens next; threads draw in any order."""

    def __init__(self, seed):
        self._random = random.Random(seed)
        self._lock = threading.Lock()
        # From never to often.
        self.failing = self._random.choice([0.0, 0.03, 0.15])
        self.slow = self._random.choice([0.0, 0.2, 0.6])

    def happens(self, probability):
        with self._lock:
            return self._random.random() < probability

    def choice(self, options):
        with self._lock:
            return self._random.choice(options)

    def dawdle(self):
        if self.happens(self.slow):
            time.sleep(0.0005 * self.choice([1, 2, 4, 8]))


class RandomAnalyzer(FakeAnalyzer):
    """Fails and dawdles at random; remembers which of its sweeps it confirmed, and where."""

    def __init__(self, chance):
        super().__init__()
        self._chance = chance
        self.confirmed = set()

    def sweep(self):
        self._chance.dawdle()
        if self._chance.happens(self._chance.failing):
            raise DeviceError(Message("the VNA did not answer"))
        return super().sweep()

    def confirm(self, number):
        self._chance.dawdle()
        assert number == self.sweeps
        if self._chance.happens(self._chance.failing):
            raise UnconfirmedError(Message("changed by hand"), self._chance.happens(0.7))
        if self._chance.happens(self._chance.failing):
            raise DeviceError(Message("the VNA driver did not answer"))
        self.confirmed.add(number)
        return SweepConfirmation()


class RandomAxis(FakeAxis):
    """Fails some of its moves."""

    def __init__(self, chance, finds_zero):
        super().__init__(finds_zero)
        self._chance = chance

    def begin_move(self, target):
        super().begin_move(target)
        if self._chance.happens(0.3 * self._chance.failing):
            self._outcome = MoveOutcome(False, verbatim("the endstop was pressed"))

    def move_outcome(self, wait_s):
        self._chance.dawdle()
        return super().move_outcome(wait_s)


class RandomStorage(StrictStorage):
    """Fails to store some traces, and takes its time with others; notes their order."""

    def __init__(self, chance):
        super().__init__()
        self._chance = chance
        self.order = []

    def store(self, sample):
        self._chance.dawdle()
        if self._chance.happens(self._chance.failing):
            raise DeviceError(Message("the disk is full"))
        super().store(sample)
        assert sample.index not in self.order
        self.order.append(sample.index)


def operate(bench, chance, survey_id):
    """Make random requests, and what an operator does to finish the survey."""
    process = 1
    deadline_s = time.monotonic() + LIMIT_S
    interfering = chance.choice([0.0, 0.05, 0.15])
    while bench.board.status.state is not State.FINISHED:
        assert time.monotonic() < deadline_s, f"still {bench.board.status}"
        time.sleep(0.001)
        state = bench.board.status.state
        try:
            if state is State.PAUSED:
                bench.control.resume("")
            elif not state.running:
                bench.control.resume(folder_of(survey_id))
            elif chance.happens(interfering):
                chance.choice([bench.control.pause, bench.control.pause, bench.control.stop])()
            elif chance.happens(0.2 * interfering):
                node = chance.choice(list(NODES))
                process += 1
                bench.nodes.note_silent(node)
                bench.nodes.note_alive(node, process)
        except RequestRefusedError:
            # The state has changed since.
            continue
        except DeviceError as error:
            assert "is finished and complete" in str(error)
            bench.wait_for(State.FINISHED)


def test_every_sample_is_stored_once_in_order_and_only_if_it_was_confirmed():
    for seed in range(DRAWS):
        print("seed", seed)
        run_survey(seed)


def run_survey(seed):
    chance = Chance(seed)
    analyzer, storage = RandomAnalyzer(chance), RandomStorage(chance)
    # Some surveys return to their first stop to see the drift.
    interval_s = chance.choice([0.0, 12.0])
    bench = Bench(
        analyzer=analyzer, storage=storage, return_limit_s=3600.0, reference_interval_s=interval_s
    )
    for name, axis_id in zip("xyz", list(bench.robot.axes)):
        axis = RandomAxis(chance, finds_zero=name != "z")
        setattr(bench, name, axis)
        bench.robot.axes[axis_id] = axis
    survey_id = bench.start()
    # A survey that was stopped before it had a folder cannot be resumed.
    bench.wait_until(lambda: storage.records)
    try:
        operate(bench, chance, survey_id)
    finally:
        bench.control.shut_down(LIMIT_S)
    assert storage.order == list(range(len(PLAN)))
    samples = storage.samples[survey_id]
    numbers = [round(samples[index].s21_real[0]) for index in storage.order]
    assert numbers == sorted(set(numbers))
    assert set(numbers) <= analyzer.confirmed
    for index, sample in samples.items():
        point = PLAN[index]
        assert (sample.x_coord_mm, sample.y_coord_mm, sample.z_coord_deg) == (
            point.x_mm,
            point.y_mm,
            point.z_deg,
        )
