"""When the end of a sweep is asked for, after sweeps whose end came late."""

from gpr20_vna_acquisition.mid.sweep_timing import REMEMBERED, SweepEnd, SweepTiming

USUAL_S, LATE_S = 0.2, 0.25


def end(asked_s):
    return SweepEnd(asked_s, asked_s + 0.001, cleared=True)


def noted(timing, ends):
    for one in ends:
        timing.note(one, late=one.asked_s > USUAL_S)
    return timing


def test_one_late_sweep_among_many_does_not_delay_those_that_follow():
    timing = noted(SweepTiming([end(USUAL_S)]), [end(USUAL_S)] * REMEMBERED)
    assert noted(timing, [end(LATE_S)]).expected_s == USUAL_S


def test_sweeps_that_became_slower_are_expected_to_be_slow():
    timing = noted(SweepTiming([end(USUAL_S)]), [end(USUAL_S)] * REMEMBERED)
    assert noted(timing, [end(LATE_S)] * (REMEMBERED // 4)).expected_s == LATE_S


def test_soon_after_the_settings_changed_every_late_sweep_counts():
    assert noted(SweepTiming([end(USUAL_S)]), [end(LATE_S)]).expected_s == LATE_S
