"""A whole survey over a fake robot: its order, its failures, its ends."""

import json
import math
import threading
from dataclasses import asdict, replace

import pytest
from fake_robot import AXES, LIMIT_S, PARAMETERS, TRAVEL, Bench, FakeAnalyzer, ManualClock

from gpr20_main_control.errors import DeviceError, RequestRefusedError
from gpr20_main_control.mid.coverage import SampleState
from gpr20_main_control.mid.robot import ReopenedSurvey, StoredTrace, SweepSetting
from gpr20_main_control.mid.survey_parameters import SurveyParametersError
from gpr20_main_control.mid.survey_plan import survey_points
from gpr20_main_control.mid.survey_state import SurveyState as State


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.storage.free.set()
    for axis in bench.axes:
        axis.blocked.set()
    bench.control.shut_down(LIMIT_S)


@pytest.mark.parametrize("x_points", [3, 4])
def test_a_survey_stores_every_point_exactly_once_and_finishes(bench, x_points):
    bench.start(x_points=x_points)
    status = bench.wait_for(State.FINISHED)
    total = x_points * 4 * 2
    assert [sample.index for sample in bench.storage.samples] == list(range(total))
    places = {(s.x_coord_mm, s.y_coord_mm, s.z_coord_deg) for s in bench.storage.samples}
    assert len(places) == total
    assert len({sample.sample_id for sample in bench.storage.samples}) == total
    assert status.completion_percent == 100.0
    assert status.remaining_s == 0.0
    assert bench.states == ["CONFIGURED", "CHECKING", "HOMING", "SURVEYING", "FINISHED"]
    assert [outcome for _id, outcome, _reason in bench.storage.closed] == ["finished"]


def test_every_sample_has_a_sweep_of_its_own_taken_where_it_says(bench):
    places = []
    bench.analyzer.on_sweep = lambda: places.append(
        (bench.x.coordinate, bench.y.coordinate, bench.z.coordinate)
    )
    bench.start()
    bench.wait_for(State.FINISHED)
    samples = bench.storage.samples
    assert [sample.sweep.s21_real[0] for sample in samples] == list(range(1, 25))
    assert [(s.x_coord_mm, s.y_coord_mm, s.z_coord_deg) for s in samples] == places


def test_each_axis_gets_its_own_targets(bench):
    bench.start()
    bench.wait_for(State.FINISHED)
    assert set(bench.x.moves) == {10.0, 20.0, 30.0}
    assert set(bench.y.moves) == {5.0, 15.0, 25.0, 35.0}
    assert set(bench.z.moves) == {0.0, 90.0}


def test_no_move_of_zero_length_is_sent(bench):
    bench.start()
    bench.wait_for(State.FINISHED)
    for axis in bench.axes:
        assert all(a != b for a, b in zip([0.0, *axis.moves], axis.moves))


def test_the_metadata_say_what_was_measured_with_what(bench):
    survey_id = bench.start()
    bench.wait_for(State.FINISHED)
    record = bench.storage.records[0]
    metadata = json.loads(record.metadata_json)
    assert record.survey_id == survey_id
    assert metadata["simulated"] is True
    assert metadata["parameters"]["x_points"] == 3
    assert metadata["instrument"]["identity"] == "Anritsu,MS2026C/2,SIMULATED,1.0"
    assert metadata["axes"]["x"]["max_coord"] == 650.0
    assert record.needed_bytes > 24 * 5 * 100


def test_homed_axes_are_not_homed_again(bench):
    bench.x.homed = bench.y.homed = bench.z.homed = True
    bench.start()
    bench.wait_for(State.FINISHED)
    assert [axis.homings for axis in bench.axes] == [0, 0, 0]


def test_a_refused_move_is_never_measured_and_pauses_the_survey(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "y axis did not reach 5 mm: the endstop was pressed" in status.message
    assert bench.analyzer.sweeps == 0
    bench.y.fail_move = ""
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_move_that_ends_elsewhere_is_never_measured(bench):
    bench.x.stay = True
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "the x axis stands at 0 mm instead of 10 mm" in status.message
    assert bench.storage.samples == []


def test_a_lost_result_is_settled_by_the_axis_own_coordinate(bench):
    bench.x.lose_result = True
    bench.start()
    bench.wait_for(State.FINISHED)
    assert len(bench.storage.samples) == 24


def test_a_move_that_never_ends_pauses_the_survey_after_its_time_limit(bench):
    bench.x.blocked.clear()
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "did not end its move to 10 mm within" in status.message
    assert bench.x.stops > 0


def test_a_silent_axis_pauses_the_survey_and_it_goes_on_when_it_speaks_again(bench):
    bench.analyzer.on_sweep = lambda: setattr(bench.z, "silent", bench.analyzer.sweeps == 5)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "z axis is silent" in status.message
    bench.analyzer.on_sweep = lambda: None
    bench.z.silent = False
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_an_axis_that_lost_its_zero_is_homed_before_the_survey_goes_on(bench):
    def lose_zero():
        if bench.analyzer.sweeps == 5:
            bench.x.homed = False
            bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = lose_zero
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "x axis is not homed" in status.message
    assert len(bench.storage.samples) <= 5
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert bench.x.homings == 2
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_trace_is_not_stored_if_the_axes_moved_during_its_sweep(bench):
    def push():
        bench.x.coordinate += 0.01
        bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = push
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "moved during the sweep at point 0" in status.message
    assert bench.storage.samples == []


def test_a_failed_sweep_is_repeated_after_connecting_again(bench):
    bench.analyzer.failures = 2
    bench.start()
    bench.wait_for(State.FINISHED)
    assert len(bench.analyzer.connections) == 3
    assert len(bench.storage.samples) == 24


def test_a_sweep_that_keeps_failing_pauses_the_survey_and_nothing_wrong_is_stored(bench):
    bench.analyzer.failures = 3
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "the VNA did not answer" in status.message
    assert bench.storage.samples == []
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert len(bench.storage.samples) == 24


@pytest.mark.parametrize("status", [0, 4, 7])
def test_an_uncalibrated_instrument_is_refused_before_anything_moves(bench, status):
    bench.analyzer.calibration_status = status
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert f"calibration status is {status}" in final.message
    assert [axis.homings for axis in bench.axes] == [0, 0, 0]
    assert bench.storage.records == []


@pytest.mark.parametrize("status", [1, 2, 3])
def test_a_moderate_calibration_is_accepted(bench, status):
    bench.analyzer.calibration_status = status
    bench.start()
    bench.wait_for(State.FINISHED)


def test_a_full_disk_at_the_start_is_refused_before_anything_moves(bench):
    bench.storage.fail_open = "0 bytes are free"
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "0 bytes are free" in final.message
    assert [axis.homings for axis in bench.axes] == [0, 0, 0]


def test_a_failed_height_pauses_the_survey(bench):
    bench.analyzer.on_sweep = lambda: setattr(bench.height, "failures", 3)
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "height could not be measured" in status.message


def test_a_failed_height_is_stored_as_none_where_that_is_the_policy():
    bench = Bench(on_height_failure="store_without")
    bench.height.failures = 10**6
    bench.start()
    bench.wait_for(State.FINISHED)
    sample = bench.storage.samples[0]
    assert math.isnan(sample.antennae_height_m)
    assert any("no height" in remark for remark in sample.quality)


def test_a_failing_disk_pauses_the_survey_and_loses_nothing(bench):
    bench.storage.failures = 3
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "could not be stored: the disk is full" in status.message
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    # The storage may have been restarted: the survey is opened again, not anew.
    assert len(bench.storage.records) == 1
    assert bench.storage.reopenings == ["survey"]
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_slow_disk_makes_the_survey_wait(bench):
    bench.storage.free.clear()
    fifth, sixth = threading.Event(), threading.Event()

    def note():
        # Called at the beginning of a sweep, before it is counted.
        {4: fifth, 5: sixth}.get(bench.analyzer.sweeps, threading.Event()).set()

    bench.analyzer.on_sweep = note
    bench.start()
    # One trace is being stored and four wait; a sixth would have no room.
    assert fifth.wait(LIMIT_S)
    assert not sixth.wait(0.5)
    assert bench.board.status.visited_points == 0
    bench.storage.free.set()
    bench.wait_for(State.FINISHED)
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_stop_during_a_move_ends_as_stopped_with_what_was_measured(bench):
    def block():
        if bench.analyzer.sweeps == 2:
            for axis in bench.axes:
                axis.blocked.clear()

    bench.analyzer.on_sweep = block
    bench.start()
    bench.wait_for_visited(2)
    message = bench.control.stop()
    assert "STOPPED" in message
    for axis in bench.axes:
        assert axis.stops > 0
        axis.blocked.set()
    final = bench.wait_for(State.STOPPED)
    assert bench.states[-2:] == ["STOPPING", "STOPPED"]
    assert final.target is None
    assert len(bench.storage.samples) < 24
    assert bench.storage.closed[-1][1] == "stopped"


def test_a_paused_survey_can_be_stopped(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.stop()
    bench.wait_for(State.STOPPED)


def test_a_folder_that_holds_too_few_traces_is_never_called_finished(bench):
    bench.storage.lose = 1
    bench.start()
    final = bench.wait_for(State.FAILED, State.FINISHED)
    assert final.state is State.FAILED
    assert "23 of 24 traces" in final.message


def test_a_fault_in_the_survey_itself_stops_the_axes_and_is_told(bench, monkeypatch):
    monkeypatch.setattr(threading, "excepthook", lambda arguments: None)

    def break_down():
        raise ZeroDivisionError("a fault of ours")

    bench.analyzer.on_sweep = break_down
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "a fault of ours" in final.message
    assert all(axis.stops > 0 for axis in bench.axes)
    assert bench.storage.closed[-1][1] == "failed"


def test_requests_that_do_not_fit_the_state_are_refused_with_the_reason(bench):
    with pytest.raises(RequestRefusedError, match="no parameters"):
        bench.control.start()
    with pytest.raises(RequestRefusedError, match="nothing to stop"):
        bench.control.stop()
    with pytest.raises(RequestRefusedError, match="no survey is paused"):
        bench.control.resume("")
    bench.storage.free.clear()
    bench.start()
    for request in (bench.control.start, lambda: bench.start(x_points=4)):
        with pytest.raises(RequestRefusedError, match="a survey is"):
            request()
    bench.storage.free.set()
    bench.wait_for(State.FINISHED)


def test_resume_names_the_survey_that_is_paused(bench):
    bench.y.fail_move = "the endstop was pressed"
    survey_id = bench.start()
    bench.wait_for(State.PAUSED)
    with pytest.raises(RequestRefusedError, match=survey_id):
        bench.control.resume("another")
    bench.y.fail_move = ""
    bench.control.resume(survey_id)
    bench.wait_for(State.FINISHED)


def test_a_second_survey_can_follow_the_first(bench):
    first = bench.start()
    bench.wait_for(State.FINISHED)
    second = bench.start(x_points=5)
    assert second != first
    bench.wait_for(State.FINISHED)
    assert len(bench.storage.samples) == 24 + 40


def test_the_target_is_shown_while_a_survey_runs_and_only_then(bench):
    bench.start()
    bench.wait_for(State.FINISHED)
    planned = survey_points(PARAMETERS, TRAVEL)
    shown = [status.target for status in bench.history if status.target is not None]
    assert set(planned) == set(shown)
    assert bench.board.status.target is None


def test_an_axis_whose_node_is_still_starting_is_waited_for(bench):
    bench.z.silent_readings = 3
    bench.start()
    bench.wait_for(State.FINISHED)


def test_an_axis_that_never_speaks_fails_the_survey_before_anything_moves(bench):
    bench.z.silent = True
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "z axis is silent" in final.message
    assert bench.x.moves == []


def test_the_estimate_follows_the_speed_of_the_robot():
    real = Bench(settle_s=1.0).control.set_parameters(PARAMETERS)
    fast = Bench(time_scale=50.0, settle_s=1.0).control.set_parameters(PARAMETERS)
    assert real.total_points == fast.total_points == 24
    assert real.duration_s == pytest.approx(50.0 * fast.duration_s)
    assert real.duration_s > 24 * 1.0


@pytest.mark.parametrize("offset", [0.01, -0.01, 0.04])
def test_an_axis_that_rests_a_step_beside_its_target_is_never_measured(bench, offset):
    bench.x.offset = offset
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "instead of 10 mm" in status.message
    assert bench.storage.samples == []


def test_an_instrument_that_accepts_another_sweep_is_refused(bench):
    bench.analyzer.accept = lambda setting: replace(setting, points=201)
    bench.start()
    final = bench.wait_for(State.FAILED)
    assert "points=201" in final.message
    assert bench.storage.records == []


def test_a_survey_never_goes_on_with_other_frequencies(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.y.fail_move = ""
    usual = bench.analyzer.frequencies_hz
    bench.analyzer.frequencies_hz = lambda: (*usual()[:-1], 5.9e9)
    bench.control.resume("")
    bench.wait_for_message("no longer those of this survey")
    bench.wait_for(State.PAUSED)
    assert bench.storage.samples == []


def test_wrong_parameters_are_refused_and_the_former_ones_stay(bench):
    bench.control.set_parameters(PARAMETERS)
    with pytest.raises(SurveyParametersError, match="x points is 2"):
        bench.control.set_parameters(replace(PARAMETERS, x_points=2))
    bench.control.start()
    bench.wait_for(State.FINISHED)
    assert len(bench.storage.samples) == 24


def test_a_survey_can_follow_one_that_was_stopped(bench):
    bench.y.fail_move = "the endstop was pressed"
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    bench.y.fail_move = ""
    bench.start()
    bench.wait_for(State.FINISHED)


def test_shutting_down_stops_the_axes_and_ends_the_survey(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    threading.Timer(0.05, bench.x.blocked.set).start()
    bench.control.shut_down(LIMIT_S)
    assert all(axis.stops > 0 for axis in bench.axes)
    assert bench.board.status.state is State.STOPPED


def test_every_sweep_comes_after_the_antennas_have_settled():
    clock = ManualClock()
    bench = Bench(clock=clock, settle_s=0.7)
    settled = []
    bench.analyzer.on_sweep = lambda: settled.append(clock.waits_s.count(0.7))
    bench.start()
    bench.wait_for(State.FINISHED)
    assert settled == list(range(1, 25))


def test_a_pause_does_not_count_for_the_remaining_time_and_loses_none():
    clock = ManualClock()
    bench = Bench(clock=clock)

    def pass_time():
        clock.time_s += 10.0
        if bench.analyzer.sweeps == 5:
            bench.y.fail_move = "the endstop was pressed"

    bench.analyzer.on_sweep = pass_time
    bench.start()
    bench.wait_for(State.PAUSED)
    clock.time_s += 1.0e6
    bench.y.fail_move = ""
    bench.analyzer.on_sweep = lambda: None
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert max(status.remaining_s for status in bench.history) < 1000.0
    # Nor is the pace before the pause forgotten.
    assert all(status.remaining_s > 0.0 for status in bench.history if status.visited_points == 6)


def test_a_stop_does_not_wait_for_an_instrument_that_hangs(bench):
    swept, hang = threading.Event(), threading.Event()

    def hang_up():
        swept.set()
        hang.wait(LIMIT_S)

    bench.analyzer.on_sweep = hang_up
    bench.start()
    assert swept.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    assert not hang.is_set()
    hang.set()
    assert bench.storage.samples == []


def test_a_stop_does_not_wait_for_an_axis_that_hangs_in_its_homing(bench):
    bench.y.hanging.clear()
    bench.start()
    bench.wait_for(State.HOMING)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    bench.y.hanging.set()


def test_every_axis_is_homed_even_if_one_fails_and_the_failure_is_told(bench):
    bench.x.fail_homing = "it is stuck open"
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "homing the x axis failed: it is stuck open" in status.message
    assert [axis.homings for axis in bench.axes] == [1, 1, 1]


def paused_on_request(bench, after):
    """Pause a survey once so many sweeps have begun; return its id."""

    def ask():
        if bench.analyzer.sweeps == after - 1:
            bench.control.pause()

    bench.analyzer.on_sweep = ask
    survey_id = bench.start()
    bench.wait_for(State.PAUSED)
    bench.analyzer.on_sweep = lambda: None
    return survey_id


@pytest.mark.parametrize("after", [1, 7, 23])
def test_a_pause_finishes_the_present_sample_and_holds(bench, after):
    paused_on_request(bench, after)
    assert bench.analyzer.sweeps == after
    bench.wait_for_visited(after)
    assert "PAUSING" in bench.states
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_pause_at_the_last_sample_ends_as_finished(bench):
    bench.analyzer.on_sweep = lambda: bench.analyzer.sweeps == 23 and bench.control.pause()
    bench.start()
    bench.wait_for(State.FINISHED)
    assert len(bench.storage.samples) == 24


def test_only_a_survey_that_measures_can_be_paused(bench):
    with pytest.raises(RequestRefusedError, match="nothing to pause"):
        bench.control.pause()
    paused_on_request(bench, 2)
    with pytest.raises(RequestRefusedError, match="PAUSED.*nothing to pause"):
        bench.control.pause()


def test_the_coverage_says_of_every_sample_what_became_of_it(bench):
    def break_down():
        if bench.analyzer.sweeps == 4:
            bench.analyzer.failures = 3

    bench.analyzer.on_sweep = break_down
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.wait_for_visited(4)
    bench.control.stop()
    bench.wait_for(State.STOPPED)
    report = bench.storage.reports[-1]
    assert report["coverage"] == "mmmmf" + 19 * "-"
    assert report["failed"] == [{"index": 4, "reason": "the VNA did not answer"}]
    assert report["verdict"].startswith("INCOMPLETE: 4 of 24 planned traces are stored, 1 failed")
    assert bench.coverages[-1][0].count(SampleState.MEASURED) == 4


def test_a_finished_survey_is_complete_and_only_then_that_word_appears(bench):
    bench.start()
    status = bench.wait_for(State.FINISHED)
    assert "complete: all 24 planned traces are stored" in status.message
    assert bench.storage.reports[-1]["coverage"] == 24 * "m"
    early = [verdict for _states, verdict in bench.coverages[:-1]]
    assert early and not any(verdict.complete for verdict in early)
    assert all("complete:" not in verdict.text for verdict in early)


def test_after_an_axis_was_homed_again_the_last_point_is_measured_as_a_control(bench):
    def lose_zero():
        if bench.analyzer.sweeps == 5:
            bench.x.homed = False
            bench.analyzer.on_sweep = lambda: None

    bench.analyzer.on_sweep = lose_zero
    bench.start()
    bench.wait_for(State.PAUSED)
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    report = bench.storage.reports[-1]
    (control,) = report["controls"]
    # The fifth sweep was taken twice: the trace says 5 or less, the control one more than all.
    assert control["index"] == bench.storage.samples[4].index
    assert report["coverage"].count("r") == 1
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def cut_off_survey(bench, stored, **changes):
    """Put a survey that was cut off on the disk of the bench: these samples are stored."""
    metadata = {
        "simulated": True,
        "parameters": asdict(PARAMETERS),
        "axes": {axis_id.value: asdict(one) for axis_id, one in AXES.items()},
        **changes,
    }
    last = (
        StoredTrace(max(stored), 0.2, analyzer_frequencies(), (1.0,) * 5, (1.0,) * 5)
        if stored
        else None
    )
    bench.storage.reopened = ReopenedSurvey(
        "5ec1a5d2-0000-4000-8000-000000000000",
        "/data/survey",
        json.dumps(metadata),
        "",
        tuple(sorted(stored)),
        last,
    )


def analyzer_frequencies():
    analyzer = FakeAnalyzer()
    analyzer.configure(SweepSetting(600.0e6, 6.0e9, 5))
    return analyzer.frequencies_hz()


@pytest.mark.parametrize("stored", [[], [0], [0, 1, 2, 3, 4], [0, 2, 5, 23], list(range(23))])
def test_a_survey_that_was_cut_off_goes_on_with_exactly_what_is_missing(bench, stored):
    cut_off_survey(bench, stored)
    bench.x.homed = bench.y.homed = bench.z.homed = True
    message = bench.control.resume("20260101T000000_5ec1a5d2")
    assert f"{24 - len(stored)} of 24 traces to go" in message
    status = bench.wait_for(State.FINISHED)
    assert status.survey_id == "5ec1a5d2-0000-4000-8000-000000000000"
    missing = [index for index in range(24) if index not in stored]
    assert [sample.index for sample in bench.storage.samples] == missing
    assert [axis.homings for axis in bench.axes] == [1, 1, 1]
    controls = bench.storage.reports[-1]["controls"]
    assert [control["index"] for control in controls] == ([max(stored)] if stored else [])
    assert bench.storage.records == []


def test_the_control_measurement_tells_how_far_it_is_from_the_stored_trace(bench):
    cut_off_survey(bench, [0, 1])
    bench.control.resume("survey")
    bench.wait_for(State.FINISHED)
    (control,) = bench.storage.reports[-1]["controls"]
    # The first sweep of this analyzer is 1 + 1j everywhere, which is what is stored.
    assert control["difference_db"] is None
    assert control["height_difference_m"] == 0.0
    said = [status.message for status in bench.history]
    assert any("point 1 differs by -inf dB" in message for message in said)


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"simulated": False}, "measured by the real robot.* a simulated one"),
        ({"parameters": {}}, "survey.json is not whole"),
        ({"axes": {}}, "with step_size None of the x axis"),
    ],
)
def test_a_survey_that_this_robot_cannot_go_on_with_is_refused_and_closed(bench, changes, message):
    cut_off_survey(bench, [0, 1], **changes)
    with pytest.raises(RequestRefusedError, match=message):
        bench.control.resume("survey")
    assert bench.board.status.state is State.IDLE
    assert bench.storage.closed[-1][1] == "failed"


def test_a_survey_that_is_not_there_is_refused(bench):
    with pytest.raises(DeviceError, match="there is no survey nowhere"):
        bench.control.resume("nowhere")
    assert bench.board.status.state is State.IDLE


def test_a_sweep_with_another_setting_than_the_surveys_is_never_stored(bench):
    def set_up_another():
        if bench.analyzer.sweeps == 3:
            bench.analyzer.other_setting = SweepSetting(1.0e9, 2.0e9, 5)

    bench.analyzer.on_sweep = set_up_another
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "nobody else may set it up" in status.message
    bench.wait_for_visited(3)
    assert len(bench.storage.samples) == 3
    bench.analyzer.on_sweep = lambda: None
    bench.analyzer.other_setting = None
    bench.control.resume("")
    bench.wait_for(State.FINISHED)
    assert [sample.index for sample in bench.storage.samples] == list(range(24))


def test_a_calibration_that_is_lost_during_the_survey_pauses_it(bench):
    def lose_it():
        if bench.analyzer.sweeps == 3:
            bench.analyzer.calibration_status = 0

    bench.analyzer.on_sweep = lose_it
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "calibration status is 0 (no calibration)" in status.message
    bench.wait_for_visited(3)
    assert len(bench.storage.samples) == 3


def test_an_axis_that_somebody_else_moved_during_the_settling_is_never_measured():
    clock = ManualClock()
    bench = Bench(clock=clock, settle_s=0.7)

    usual = clock.wait_s

    def meddle(event, timeout_s):
        if timeout_s == 0.7 and len(bench.storage.samples) >= 2:
            bench.z.coordinate = -5.4
        return usual(event, timeout_s)

    clock.wait_s = meddle
    bench.start()
    status = bench.wait_for(State.PAUSED)
    assert "z_deg=-5.4" in status.message
    assert all(sample.z_coord_deg in (0.0, 90.0) for sample in bench.storage.samples)
    bench.control.stop()
    bench.wait_for(State.STOPPED)


def test_stopped_is_said_only_when_no_axis_moves_any_more(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.stop()
    bench.wait_for(State.STOPPING)
    at_rest = []
    threading.Timer(0.005, lambda: (at_rest.append(True), bench.x.blocked.set())).start()
    bench.wait_for(State.STOPPED)
    assert at_rest or "STILL MOVES" in bench.board.status.message


def test_an_axis_that_does_not_stop_is_told(bench):
    bench.x.blocked.clear()
    bench.start()
    assert bench.x.begun.wait(LIMIT_S)
    bench.control.stop()
    final = bench.wait_for(State.STOPPED)
    assert "AN AXIS STILL MOVES" in final.message
