"""What a survey relies on an analyzer for: checks over any transport, and of any class.

A check is a function that returns what it found, or raises. A test makes them with simulated
instruments, check_analyzer with the real one.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any, Callable, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from gpr20_common.errors import Gpr20Error, InvalidValueError
from gpr20_common.faults import CONFIGURATION
from gpr20_common.low.clock import Clock
from gpr20_common.message import Message, verbatim
from gpr20_survey.trace.sweep import AnalyzerSettings, Sweep, SweepSettings
from gpr20_vna_acquisition import errors
from gpr20_vna_acquisition.errors import VnaError, old_data
from gpr20_vna_acquisition.mid.analyzers import Analyzer, Result, Status, make_analyzer
from gpr20_vna_acquisition.mid.exchanges import RequestDeadline, Transport
from gpr20_vna_acquisition.mid.ms2026c_commands import (
    DATA_QUERY,
    STATUS_QUERY,
    SWEEP_COMPLETE_BIT,
    TRIGGER,
)
from gpr20_vna_acquisition.mid.trace_quality import has_old_points, refuse_impossible
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C, VnaParameters

Ask = Callable[[Message], None]
Outcome = Tuple[Status, Message]
# A point takes at least about the inverse of the IF bandwidth; some filters settle sooner.
LEAST_FILTER_SHARE = 0.3
# Sweeps of different things differ by so many times more than those of the same one.
CLEAR_DIFFERENCE = 5.0


class NotAsPromisedError(VnaError):
    """An analyzer breaks a promise of the protocol."""

    fault = CONFIGURATION


@dataclass(frozen=True)
class Extent:
    """How much is tried; times in seconds, the IF bandwidths [Hz] where the analyzer has them.

    The display of an MS2026C is watched for `watched_s`; a check may take `limit_s`.
    """

    points: int = 51
    bandwidths_hz: Tuple[float, ...] = (100_000.0, 10_000.0, 1000.0, 100.0)
    sweeps: int = 20
    watched_s: float = 1.2
    limit_s: float = 40.0


class Bench:
    """Makes objects of the class that is checked, one of which has a link at a time.

    `connect` opens a link to an address; a class outside this package has its own. `ask` asks a
    person to do something, and returns when it is done; None: nobody is there.
    """

    def __init__(
        self,
        parameters: VnaParameters,
        connect: Callable[[str], Transport],
        extent: Extent,
        ask: Optional[Ask] = None,
    ) -> None:
        self.parameters, self.connect, self.extent, self.ask = parameters, connect, extent, ask
        self.clock = Clock()
        self.deadline = RequestDeadline(self.clock)
        self._made: List[Analyzer] = []
        first_hz, last_hz = parameters.min_frequency_hz, parameters.max_frequency_hz
        low, middle, high = (
            float(round(first_hz + part * (last_hz - first_hz))) for part in (0.1, 0.5, 0.9)
        )
        self.low = SweepSettings(low, middle, extent.points)
        self.high = SweepSettings(middle, high, extent.points)

    def linked(self, **changes: Any) -> Tuple[Analyzer, str]:
        """Return a new object with a link, and the identification; some parameters may differ."""
        parameters = replace(self.parameters, **changes)
        self._made.append(make_analyzer(parameters, self.connect, self.deadline))
        return self._made[-1], self.relinked(self._made[-1])

    def relinked(self, analyzer: Analyzer) -> str:
        """Make a link, the only one, and return the identification."""
        for one in self._made:
            one.disconnect()
        analyzer.connect(self.parameters.address)
        return analyzer.identify()

    def set_up(self, settings: SweepSettings) -> Tuple[Analyzer, SweepSettings]:
        """Return a new object with a link, and the settings that it has confirmed."""
        analyzer, _identity = self.linked()
        return analyzer, analyzer.configure(settings)

    def clear(self) -> None:
        """Leave the instrument sweeping by itself, without any link."""
        for analyzer in self._made:
            analyzer.release()
            analyzer.disconnect()
        self._made.clear()


def results(bench: Bench) -> Iterator[Result]:
    """Make every check and yield its result; only the first one if it fails."""
    for check in CHECKS:
        bench.deadline.begin(bench.extent.limit_s, extensible=True)
        try:
            status, text = check(bench)
        except Gpr20Error as error:
            status, text = Status.FAILED, error.message
        finally:
            bench.clear()
        yield Result(check.__name__, status, text)
        if check is identity and status is Status.FAILED:
            return


def identity(bench: Bench) -> Outcome:
    """The identification stays the same, and one that is not expected is refused."""
    analyzer, first = bench.linked()
    found = {first, analyzer.identify(), bench.relinked(analyzer), bench.linked()[1]}
    if len(found) > 1:
        raise NotAsPromisedError(Message("it identifies itself as {found}", found=sorted(found)))
    for key in ("maker", "model"):
        refusal = _refusal(functools.partial(bench.linked, **{key: "no such"}))
        if not isinstance(refusal, errors.VnaIdentityError):
            raise refusal or NotAsPromisedError(Message("it accepts another {key}", key=key))
    return Status.PASSED, verbatim(first)


def sweep_times(bench: Bench) -> Outcome:
    """A narrower IF bandwidth takes the time that its filter needs."""
    analyzer, usual = bench.set_up(bench.low)
    shown: List[str] = []
    for bandwidth_hz in bench.extent.bandwidths_hz:
        wanted = replace(bench.low, analyzer=AnalyzerSettings(bandwidth_hz, 1))
        try:
            analyzer.check_sweep(wanted)
            accepted = analyzer.configure(wanted)
        except (InvalidValueError, errors.VnaSettingError):
            continue  # it has others
        _check_made(analyzer, accepted, wanted)
        sweep_s = analyzer.sweep().duration_s
        shown.append(f"{bandwidth_hz:g} Hz: {sweep_s:.3g} s")
        if sweep_s < LEAST_FILTER_SHARE * wanted.points / bandwidth_hz:
            raise NotAsPromisedError(
                Message("a sweep is shorter than its filter needs: {last}", last=shown[-1])
            )
    analyzer.configure(usual)
    if not shown:
        return Status.NOT_TESTED, Message("it sets none of the IF bandwidths")
    return Status.PASSED, Message("a sweep takes {times}", times=", ".join(shown))


def new_sweeps(bench: Bench) -> Outcome:
    """Every sweep is a new one, whole, and measured after its request."""
    analyzer, _accepted = bench.set_up(bench.low)
    begun_us = bench.clock.time_of_day_us()
    sweeps = _confirmed(analyzer, bench.extent.sweeps)
    middle_s = float(np.median([one.duration_s for one in sweeps]))
    # What the driver believes may be of one sweep that a busy computer saw end late.
    usual_s = min(analyzer.trace_duration_s or 0.0, middle_s)
    numbers = [_values(one).view(np.float64) for one in sweeps]
    for index, sweep in enumerate(sweeps):
        refuse_impossible(sweep)
        if any((numbers[index] == one).all() for one in numbers[:index]):
            raise old_data()
        if index and has_old_points(numbers[index], numbers[index - 1]):
            raise old_data()
        if sweep.sweep_started_us < begun_us or sweep.duration_s < usual_s / 2.0:
            raise NotAsPromisedError(Message("a sweep begins before its request, or ends too soon"))
        begun_us = sweep.sweep_ended_us
    return Status.PASSED, Message(
        "{count} sweeps, all different; one takes {duration:.3g} s",
        count=len(sweeps),
        duration=middle_s,
    )


def first_sweep(bench: Bench) -> Outcome:
    """The first sweep after a change of the frequencies is not one from before."""
    analyzer, _accepted = bench.set_up(bench.low)
    before = _confirmed(analyzer, 1)[0]
    analyzer.configure(bench.high)
    return _judged_first(before, _confirmed(analyzer, 3))


def reconnection(bench: Bench) -> Outcome:
    """Without a link nothing is measured; a new one shows what somebody else has set meanwhile."""
    analyzer, accepted = bench.set_up(bench.low)
    analyzer.sweep()
    analyzer.disconnect()
    if _refusal(analyzer.sweep) is None:
        raise NotAsPromisedError(Message("it gives data without a link"))
    bench.set_up(bench.high)
    bench.relinked(analyzer)
    refusal = _refusal(analyzer.confirm)
    if not isinstance(refusal, (errors.VnaSettingError, errors.VnaNotReadyError)):
        raise refusal or NotAsPromisedError(Message("it confirms settings that were changed"))
    again = analyzer.configure(accepted)
    _check_made(analyzer, again, accepted)
    if again != accepted:
        raise _other_settings(again, accepted)
    return Status.PASSED, Message("a new link serves; changed settings are noticed and made again")


def sweep_end(bench: Bench) -> Outcome:
    """How late the data follow the bit of the end; `display_settle_s` must be more than that."""
    if bench.parameters.analyzer != MS2026C:
        return Status.NOT_TESTED, Message("only the messages of the MS2026C are known")
    analyzer, _accepted = bench.set_up(bench.low)
    analyzer.disconnect()
    link, now_s = bench.connect(bench.parameters.address), bench.clock.now_s
    link.write(TRIGGER)
    # Until then the bit may be that of the sweep before.
    bench.deadline.pause_s((analyzer.trace_duration_s or 0.0) / 2.0)
    while not int(link.ask_raw(STATUS_QUERY)) & SWEEP_COMPLETE_BIT:
        bench.deadline.check()
    ended_s = changed_s = now_s()
    shown = link.ask_raw(DATA_QUERY)
    while now_s() - ended_s < bench.extent.watched_s:
        before, shown = shown, link.ask_raw(DATA_QUERY)
        changed_s = changed_s if shown == before else now_s()
    link.close()
    return Status.MEASURED, Message(
        "the data follow the end of a sweep by up to {lag_ms:.1f} ms",
        lag_ms=1e3 * (changed_s - ended_s),
    )


def by_hand(bench: Bench) -> Outcome:
    """The first sweep after a person has changed what is measured shows the change."""
    if bench.ask is None:
        return Status.NOT_TESTED, Message("a person is needed: give --by-hand")
    analyzer, _accepted = bench.set_up(bench.low)
    before = _confirmed(analyzer, 2)[-1]
    bench.ask(Message("Take the cable off one port of the VNA, then press Enter."))
    bench.deadline.begin(bench.extent.limit_s, extensible=True)
    return _judged_first(before, _confirmed(analyzer, 3))


CHECKS: Tuple[Callable[[Bench], Outcome], ...] = (
    *(identity, sweep_times, new_sweeps, first_sweep, reconnection, sweep_end, by_hand),
)


def _confirmed(analyzer: Analyzer, count: int) -> Sequence[Sweep]:
    sweeps = []
    for _ in range(count):
        sweeps.append(analyzer.sweep())
        analyzer.confirm()
    return sweeps


def _refusal(action: Callable[[], Any]) -> Optional[VnaError]:
    """Do something; return the error with which the analyzer refuses it, None if it does not."""
    try:
        action()
    except VnaError as error:
        return error
    return None


def _check_made(analyzer: Analyzer, accepted: SweepSettings, wanted: SweepSettings) -> None:
    sweep = _confirmed(analyzer, 1)[0]
    made_hz, wanted_hz = sweep.frequency_hz, wanted.frequencies_hz()
    is_right = len(made_hz) == len(wanted_hz) and np.allclose(made_hz, wanted_hz, 0.0, 1.0)
    if not (is_right and accepted.fulfils(wanted) and sweep.analyzer.fulfils(wanted.analyzer)):
        raise _other_settings(accepted, wanted)


def _other_settings(found: SweepSettings, wanted: SweepSettings) -> NotAsPromisedError:
    details = f"{wanted} became {found}"
    text = Message("it does not measure with the settings that were made", details=details)
    return NotAsPromisedError(text)


def _judged_first(before: Sweep, after: Sequence[Sweep]) -> Outcome:
    """Judge whether the first of some sweeps shows what was changed before it."""
    first, second, third = after
    if _difference(before, third) < CLEAR_DIFFERENCE * _difference(second, third):
        alike = Message("the VNA measures the same as before; connect something to its ports")
        return Status.NOT_TESTED, alike
    if _difference(first, before) < _difference(first, third):
        raise old_data()
    return Status.PASSED, Message("the first sweep after a change shows it")


def _difference(one: Sweep, other: Sweep) -> float:
    if len(one.s21_real) != len(other.s21_real):
        return float("inf")
    return float(np.median(np.abs(_values(one) - _values(other))))


def _values(sweep: Sweep) -> np.ndarray:
    return sweep.s21_real + 1j * sweep.s21_imag
