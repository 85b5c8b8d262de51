"""The intervals of a trial, against sums of exact numbers, and their coverage."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from scipy.stats import binom, poisson

from gpr20_analysis.trial import ground
from gpr20_analysis.trial.documents import Mark, Plan, Seal
from gpr20_analysis.trial.ground import Lane, Target
from gpr20_analysis.trial.score import score_trial
from gpr20_analysis.trial.statistics import (
    alarm_interval,
    detection_interval,
    mcnemar,
    shown_detection,
    targets_needed,
)

EXACT, BITS = 1e-6, 40
TRIALS = [1_000, pytest.param(10_000, marks=pytest.mark.release)]


def share_at_most(found, targets, share):
    """Return the probability of at most so many detections, in exact fractions."""
    miss = 1 - share
    return sum(
        math.comb(targets, one) * share**one * miss ** (targets - one) for one in range(found + 1)
    )


def share_where(found, targets, probability):
    """Return the share at which at most `found` detections have a probability, by bisection."""
    low, high = 0, 1 << BITS
    while high - low > 1:
        middle = (low + high) // 2
        if share_at_most(found, targets, Fraction(middle, 1 << BITS)) > probability:
            low = middle
        else:
            high = middle
    return low / (1 << BITS)


def mean_where(count, probability):
    """Return the mean of a Poisson count that is at most `count` with a probability."""
    with localcontext() as context:
        context.prec = 60
        low, high = Decimal(0), Decimal(1000)
        for _ in range(120):
            middle = (low + high) / 2
            terms = [middle**one / math.factorial(one) for one in range(count + 1)]
            if (-middle).exp() * sum(terms) > Decimal(
                probability.numerator
            ) / probability.denominator:
                low = middle
            else:
                high = middle
        return float(low)


def exact_detection(found, targets, outside=Fraction(1, 40)):
    low = share_where(found - 1, targets, 1 - outside) if found else 0.0
    return low, share_where(found, targets, outside) if found < targets else 1.0


def exact_alarms(count, area_m2, outside=Fraction(1, 40)):
    low = mean_where(count - 1, 1 - outside) if count else 0.0
    return low / area_m2, mean_where(count, outside) / area_m2


@pytest.mark.parametrize(
    ("found", "targets", "published"),
    [(98, 100, (0.930, 0.998)), (50, 50, (0.929, 1.0)), (45, 48, (0.828, 0.987)),
     (0, 7, (0.0, 0.410)), (1, 1, (0.025, 1.0))],
)  # fmt: skip
def test_the_interval_of_a_share_is_that_of_the_exact_binomial_sum(found, targets, published):
    interval = detection_interval(found, targets)
    assert interval == pytest.approx(exact_detection(found, targets), abs=EXACT)
    assert interval == pytest.approx(published, abs=6e-4)


@pytest.mark.parametrize(
    ("count", "area_m2", "published"), [(12, 200.0, (0.031, 0.105)), (0, 500.0, (0.0, 0.0074))]
)
def test_the_interval_of_a_density_is_that_of_the_exact_poisson_sum(count, area_m2, published):
    interval = alarm_interval(count, area_m2)
    assert interval == pytest.approx(exact_alarms(count, area_m2), abs=EXACT)
    assert interval == pytest.approx(published, abs=6e-4)


@pytest.mark.parametrize(
    ("detection", "missed", "needed"),
    [(0.90, 0, 29), (0.95, 0, 59), (0.99, 0, 299), (0.99, 1, 473), (0.996, 0, 748)],
)
def test_the_fewest_targets_that_show_a_detection_are_the_reference_numbers(
    detection, missed, needed
):
    assert targets_needed(detection, missed) == needed
    share = Fraction(str(detection))
    for targets, shows in ((needed, True), (needed - 1, False)):
        chance = 1 - share_at_most(targets - missed - 1, targets, share)
        assert (chance <= Fraction(1, 20)) is shows
        assert (shown_detection(targets - missed, targets) >= detection) is shows


@pytest.mark.parametrize(("first", "second"), [(0, 0), (5, 0), (1, 9), (8, 8), (3, 17)])
def test_mcnemar_is_the_two_sided_binomial_test(first, second):
    tail = share_at_most(min(first, second), first + second, Fraction(1, 2))
    assert mcnemar(first, second) == pytest.approx(float(min(1, 2 * tail)), abs=1e-12)


def test_without_targets_or_ground_nothing_is_known():
    assert detection_interval(0, 0) == (0.0, 1.0)
    assert alarm_interval(3, 0.0) == (0.0, math.inf)


@pytest.mark.parametrize("targets", [1, 5, 20, 48, 100])
def test_intervals_of_shares_cover_every_true_share_in_95_of_100_trials(targets):
    ends = np.array([detection_interval(found, targets) for found in range(targets + 1)])
    for share in np.linspace(0.01, 0.99, 99):
        covered = (ends[:, 0] <= share) & (share <= ends[:, 1])
        assert binom.pmf(np.flatnonzero(covered), targets, share).sum() >= 0.95 - 1e-9


def test_intervals_of_densities_cover_every_true_density_in_95_of_100_trials():
    area_m2 = 12.5
    ends = np.array([alarm_interval(count, area_m2) for count in range(200)])
    for density in np.linspace(0.01, 4.0, 100):
        covered = (ends[:, 0] <= density) & (density <= ends[:, 1])
        assert poisson.pmf(np.flatnonzero(covered), density * area_m2).sum() >= 0.95 - 1e-9


@pytest.mark.parametrize("trials", TRIALS)
def test_intervals_of_the_scorer_cover_the_truth_in_95_of_100_trials(monkeypatch, trials):
    chance, halo_m = np.random.default_rng(29), 0.1
    lane = Lane({}, "L", 0.0, 10.0, 0.0, 2.0)
    places = [(0.5 + at, 0.5) for at in range(10)]
    targets = [Target(f"T{at}", "L", one, {}) for at, one in enumerate(places)]
    plan = Plan(halo_m, (), {"L": lane}, sha256="p")
    area_m2 = lane.area_outside(places, halo_m)
    assert area_m2 == pytest.approx(20.0 - 10 * math.pi * halo_m**2, abs=1e-4)
    # The targets of all trials are the same, so it is computed once.
    monkeypatch.setattr(ground.Lane, "area_outside", lambda *_: area_m2)
    hits = {"share": 0, "density": 0}
    for share, density in zip(chance.uniform(0.3, 1.0, trials), chance.uniform(0.0, 0.5, trials)):
        seen = [one for one in places if chance.random() < share]
        false = [(one, 1.5) for one in chance.uniform(0.0, 10.0, chance.poisson(density * area_m2))]
        marks = tuple(Mark(f"C{at}", *one, -at) for at, one in enumerate([*seen, *false]))
        (score,) = score_trial(plan, targets, [Seal(marks, "", plan_sha256="p", lane="L")]).groups
        assert (score.found, score.alarms) == (len(seen), len(false))
        for name, truth, ends in (("share", share, score.detection_range),
                                  ("density", density, score.alarms_range)):  # fmt: skip
            hits[name] += ends[0] <= truth <= ends[1]
    assert min(hits.values()) >= 0.95 * trials, hits
