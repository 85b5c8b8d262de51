"""Checks of any analyzer, by the calls that the driver makes."""

from __future__ import annotations

import contextlib
import functools
from typing import Callable, Dict, List

import numpy as np

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message, verbatim
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaIdentityError,
    VnaSettingError,
)
from gpr20_vna_acquisition.mid.analyzer import Analyzer
from gpr20_vna_acquisition.mid.conformance.bench import (
    Bench,
    NotAsPromisedError,
    Outcome,
    Status,
    check_noticed,
    confirmed,
    put_back,
    refusal_of,
    with_bandwidth,
)
from gpr20_vna_acquisition.mid.conformance.comparison import (
    judged_first,
    numbers_of,
    refuse_doubled,
)
from gpr20_vna_acquisition.mid.identity import check_identity
from gpr20_vna_acquisition.mid.refusals import old_data
from gpr20_vna_acquisition.mid.sweep_timing import has_old_points
from gpr20_vna_acquisition.mid.trace_quality import refuse_impossible

# A point takes at least about the inverse of the IF bandwidth; some filters settle sooner.
LEAST_FILTER_SHARE = 0.3


def identity(bench: Bench) -> Outcome:
    """The identification is that of the configuration, and stays the same."""
    analyzer = bench.made()
    found = [bench.linked(analyzer), analyzer.identify()]
    analyzer.disconnect()
    found.append(bench.linked(analyzer))
    analyzer.disconnect()
    found.append(bench.linked(bench.made()))
    check_identity(found[0], bench.parameters)
    for other in found:
        if other != found[0]:
            raise NotAsPromisedError(
                Message(
                    "it identifies itself as '{identity}' and then as '{other}'",
                    identity=found[0],
                    other=other,
                )
            )
    return Status.PASSED, verbatim(found[0])


def other_identity(bench: Bench) -> Outcome:
    """An instrument that is not the expected one is refused."""
    for key in ("maker", "model"):
        analyzer = bench.made(**{key: "no such"})
        refusal = refusal_of(functools.partial(bench.linked, analyzer))
        if refusal is None:
            raise NotAsPromisedError(Message("it accepts an instrument of another {key}", key=key))
        if not isinstance(refusal, VnaIdentityError):
            raise refusal
        analyzer.disconnect()
    return Status.PASSED, Message("another maker or model is refused")


def settings(bench: Bench) -> Outcome:
    """Settings are made, read back, and can be made again exactly."""
    analyzer, accepted = bench.set_up(bench.low)
    _check_made(analyzer, accepted, bench.low)
    _check_made(analyzer, analyzer.configure(bench.high), bench.high)
    again = analyzer.configure(accepted)
    _check_made(analyzer, again, accepted)
    if again != accepted:
        raise _other_settings(again, accepted)
    return Status.PASSED, accepted.analyzer.message


def sweep_times(bench: Bench) -> Outcome:
    """A narrower IF bandwidth takes the time that its filter needs."""
    analyzer, usual = bench.set_up(bench.low)
    shown: List[str] = []
    for bandwidth_hz in bench.extent.bandwidths_hz:
        wanted = with_bandwidth(bench.low, bandwidth_hz)
        try:
            analyzer.check_sweep(wanted)
            accepted = analyzer.configure(wanted)
        except (InvalidValueError, VnaSettingError):
            continue  # it has others
        _check_made(analyzer, accepted, wanted)
        sweep = analyzer.sweep()
        if sweep.duration_s < LEAST_FILTER_SHARE * wanted.points / bandwidth_hz:
            raise NotAsPromisedError(
                Message(
                    "a sweep of {points} points with an IF bandwidth of {bandwidth:g} Hz takes "
                    "{duration:.3g} s, less than the filter needs",
                    points=wanted.points,
                    bandwidth=bandwidth_hz,
                    duration=sweep.duration_s,
                )
            )
        shown.append(f"{bandwidth_hz:g} Hz: {sweep.duration_s:.3g} s")
    analyzer.configure(usual)
    if not shown:
        return Status.NOT_TESTED, Message("it sets none of the IF bandwidths")
    return Status.PASSED, Message(
        "a sweep of {points} points takes {times}",
        points=bench.extent.points,
        times=", ".join(shown),
    )


def new_sweeps(bench: Bench) -> Outcome:
    """Every sweep is a new one, whole, and measured after its request."""
    analyzer, accepted = bench.set_up(bench.low)
    begun_us = bench.clock.time_of_day_us()
    sweeps = confirmed(analyzer, bench.extent.sweeps)
    middle_s = float(np.median([one.duration_s for one in sweeps]))
    # What the driver believes may be of one sweep that a busy computer saw end late.
    usual_s = min(analyzer.trace_duration_s or 0.0, middle_s)
    # A simulated one that has none says so.
    noisy = getattr(analyzer, "has_noise", True)
    numbers = [numbers_of(one) for one in sweeps]
    for index, sweep in enumerate(sweeps):
        refuse_impossible(sweep)
        refuse_doubled(sweep)
        if noisy and any((numbers[index] == one).all() for one in numbers[:index]):
            raise old_data()
        if noisy and has_old_points(numbers[index], numbers[index - 1] if index else None):
            raise old_data()
        if sweep.sweep_started_us < begun_us or sweep.duration_s < usual_s / 2.0:
            raise NotAsPromisedError(
                Message(
                    "a sweep ends {duration:.3g} s after its request; it takes {usual:.3g} s",
                    duration=(sweep.sweep_ended_us - begun_us) * 1e-6,
                    usual=usual_s,
                )
            )
        begun_us = sweep.sweep_ended_us
    return Status.PASSED, Message(
        "{count} sweeps of {points} points, all different; one takes {duration:.3g} s",
        count=len(sweeps),
        points=accepted.points,
        duration=middle_s,
    )


def first_sweep(bench: Bench) -> Outcome:
    """The first sweep after a change of the frequencies is not one from before."""
    analyzer, _accepted = bench.set_up(bench.low)
    before = confirmed(analyzer, 1)[0]
    analyzer.configure(bench.high)
    return judged_first(
        before,
        confirmed(analyzer, 3),
        Message("the VNA measures the same at all frequencies; connect something to its ports"),
    )


def by_hand(bench: Bench, ask: Callable[[Message], None]) -> Outcome:
    """The first sweep after a person has changed what is measured shows the change.

    Args:
        bench: The analyzer.
        ask: Shows a person what to do, and returns when it is done.
    """
    analyzer, _accepted = bench.set_up(bench.low)
    before = confirmed(analyzer, 2)[-1]
    ask(Message("Take the cable off one port of the VNA, then press Enter."))
    bench.begin()
    return judged_first(
        before, confirmed(analyzer, 3), Message("nothing changed that the VNA measures")
    )


def settings_by_another(bench: Bench) -> Outcome:
    """Settings that somebody else has made are noticed, and can be restored."""
    analyzer, accepted = bench.set_up(bench.low)
    analyzer.sweep()
    analyzer.disconnect()
    bench.change_by_another(bench.high)
    bench.linked(analyzer)
    check_noticed(refusal_of(analyzer.confirm))
    if analyzer.configure(accepted) != accepted:
        raise _other_settings(analyzer.configure(accepted), accepted)
    confirmed(analyzer, 1)
    return Status.PASSED, Message("settings that were changed are noticed and made again")


def settings_put_back(bench: Bench) -> Outcome:
    """Whether settings that were changed and put back are noticed."""
    analyzer, accepted = bench.set_up(bench.low)
    analyzer.sweep()
    analyzer.disconnect()
    bench.change_by_another(bench.high, accepted)
    bench.linked(analyzer)
    return Status.MEASURED, put_back(refusal_of(analyzer.confirm) is not None)


def reconnection(bench: Bench) -> Outcome:
    """Without a link nothing is measured; a new one serves as the first did."""
    analyzer, accepted = bench.set_up(bench.low)
    analyzer.sweep()
    analyzer.disconnect()
    analyzer.disconnect()
    if refusal_of(analyzer.sweep) is None:
        raise NotAsPromisedError(Message("it gives data without a link"))
    bench.relink(analyzer, accepted)
    confirmed(analyzer, 2)
    return Status.PASSED, Message("a link that ended is made again")


def time_limit(bench: Bench) -> Outcome:
    """How long after its time limit a request ends."""
    analyzer, usual = bench.set_up(bench.low)
    with contextlib.suppress(InvalidValueError, VnaSettingError):
        # A long sweep, if it can be had.
        analyzer.configure(with_bandwidth(bench.low, bench.extent.bandwidths_hz[-1]))
    limit_s = (analyzer.trace_duration_s or 0.0) / 4.0
    begun_s = bench.clock.now_s()
    bench.deadline.begin(limit_s)
    refusal_of(analyzer.sweep)
    late_s = bench.clock.now_s() - begun_s - limit_s
    bench.begin()
    analyzer.disconnect()
    bench.change_by_another(usual)
    return Status.MEASURED, Message(
        "a sweep of {duration:.3g} s that must end after {limit:.2g} s ends {late:.2g} s later",
        duration=4.0 * limit_s,
        limit=limit_s,
        late=late_s,
    )


CHECKS: Dict[str, Callable[[Bench], Outcome]] = {
    one.__name__: one
    for one in (
        identity,
        other_identity,
        settings,
        sweep_times,
        new_sweeps,
        first_sweep,
        settings_by_another,
        settings_put_back,
        reconnection,
        time_limit,
    )
}


def _check_made(analyzer: Analyzer, accepted: SweepSettings, wanted: SweepSettings) -> None:
    if not accepted.fulfils(wanted):
        raise _other_settings(accepted, wanted)
    sweep = confirmed(analyzer, 1)[0]
    if not np.allclose(sweep.frequency_hz, wanted.frequencies_hz(), rtol=0.0, atol=1.0):
        raise _other_settings(accepted, wanted)
    if not sweep.analyzer.fulfils(wanted.analyzer):
        raise _other_settings(accepted, wanted)


def _other_settings(found: SweepSettings, wanted: SweepSettings) -> NotAsPromisedError:
    return NotAsPromisedError(
        Message(
            "it does not measure with the settings that were made",
            details=f"{wanted} became {found}",
        )
    )
