"""What a long survey leaves in the control's memory."""

import tracemalloc

from fake_robot import Bench, FakeStorage

from gpr20_survey.plan.survey_state import SurveyState as State

OURS = tracemalloc.Filter(True, "*gpr20_main_control/src/*")
ROWS = 200
EARLY, LATE = 200, 1100


class CountingStorage(FakeStorage):
    """Stores nothing; looks at the memory at two samples."""

    def __init__(self):
        super().__init__()
        self.stored = 0
        self.bytes_held = {}

    def store(self, sample):
        self.stored += 1
        if self.stored in (EARLY, LATE):
            held = tracemalloc.take_snapshot().filter_traces([OURS]).statistics("filename")
            self.bytes_held[self.stored] = sum(one.size for one in held)

    def report(self, survey_id, report_json):
        return self.stored


class Forgetful(list):
    """A list that stays empty."""

    def append(self, _one):
        pass


def test_the_control_keeps_nothing_of_a_sample_that_is_stored():
    storage = CountingStorage()
    bench = Bench(storage=storage)
    bench.history, bench.coverages = Forgetful(), Forgetful()
    tracemalloc.start()
    try:
        bench.start(y_points=ROWS, y_stop_mm=204.0)
        # Tracing makes it slow.
        bench.wait_for(State.FINISHED, limit_s=120.0)
    finally:
        tracemalloc.stop()
    assert storage.stored == 3 * ROWS * 2
    # Two sweeps of five points, a status and the like may be in flight in the one and not in
    # the other snapshot; half a kilobyte for each sample would be 450 kB.
    assert storage.bytes_held[LATE] - storage.bytes_held[EARLY] < 20_000
