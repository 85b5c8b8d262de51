"""Checks of an MS2026C by its messages: what it does, and what its class does about faults."""

from __future__ import annotations

import contextlib
from typing import Callable, Dict, Iterator, List, Optional, Tuple

import numpy as np

from gpr20_common.message import Message
from gpr20_survey.trace.sweep_settings import SweepSettings
from gpr20_vna_acquisition.errors import (
    VnaConnectionError,
    VnaError,
    VnaNoAnswerError,
    VnaTimeoutError,
)
from gpr20_vna_acquisition.mid.analyzer import Analyzer
from gpr20_vna_acquisition.mid.block_parser import parse_numbers
from gpr20_vna_acquisition.mid.conformance.bench import (
    Bench,
    NotAsPromisedError,
    Outcome,
    Status,
    check_noticed,
    confirmed,
    put_back,
    refusal_of,
)
from gpr20_vna_acquisition.mid.conformance.faulty_transport import Trouble, faulty, is_complete
from gpr20_vna_acquisition.mid.display import DATA_QUERY
from gpr20_vna_acquisition.mid.exchanges import Transport
from gpr20_vna_acquisition.mid.ms2026c_sweeps import (
    STATUS_QUERY,
    TRIGGER,
)
from gpr20_vna_acquisition.mid.refusals import old_data

# Two that are common elsewhere and not documented for this instrument, and one of nobody.
UNKNOWN_QUERIES = ("*OPC?", ":SYST:ERR?", ":GPR20:NONE?")
UNKNOWN_LIMIT_S = 2.0
WATCHED_SWEEPS = 3
# A survey confirms a sweep while the axes move, which takes at least so long [s].
SHORTEST_MOVE_S = 0.3
LATE_MEMORIES_S = (0.01, 0.2)
# A setting that no other check makes.
CHANGED, PUT_BACK = ":SENS:SWE:IFBW 2000", ":SENS:SWE:IFBW {:.0f}"
OTHER_SERIAL = b"7"


def unknown_queries(bench: Bench) -> Outcome:
    """What the instrument does with a query that it does not know."""
    shown = []
    for query in UNKNOWN_QUERIES:
        with _link(bench) as link:
            try:
                shown.append(f"{query} {link.ask_raw(query, UNKNOWN_LIMIT_S)[:40]!r}")
            except VnaNoAnswerError:
                shown.append(f"{query} -")
    with _link(bench) as link:
        link.ask_raw("*IDN?")
    return Status.MEASURED, Message(
        "answers to unknown queries, - for none within {limit:g} s",
        limit=UNKNOWN_LIMIT_S,
        details=", ".join(shown),
    )


def completion_bit(bench: Bench) -> Outcome:
    """How the bit of the end behaves after a trigger."""
    ends = [one[:2] for one in _watched(bench, 0.0)]
    return Status.MEASURED, Message(
        "the bit of the sweep before is seen for up to {stale_ms:.1f} ms after a trigger; that of "
        "the sweep itself comes after {end_ms:.1f} ms",
        stale_ms=1e3 * max(stale_s for stale_s, _end_s in ends),
        end_ms=1e3 * float(np.median([end_s for _stale_s, end_s in ends])),
    )


def display_memory(bench: Bench) -> Outcome:
    """How long after the completion bit the data still change."""
    watched = _watched(bench, bench.extent.longest_lag_s)
    return Status.MEASURED, Message(
        "the data follow the completion bit by up to {lag_ms:.1f} ms; watched for {watched:g} s",
        lag_ms=1e3 * max(lag_s for _stale_s, _end_s, lag_s in watched),
        watched=bench.extent.longest_lag_s,
    )


def late_flag(bench: Bench) -> Outcome:
    """The bit of the sweep before stays for half of a sweep."""
    analyzer, _accepted = bench.set_up(bench.low)
    duration_s = analyzer.trace_duration_s or 0.0
    analyzer.disconnect()
    return _only_fresh(bench, Trouble(late_flag_s=duration_s / 2.0))


def late_memory(bench: Bench) -> Outcome:
    """The data follow the bit late."""
    return _only_fresh(bench, *(Trouble(late_memory_s=one) for one in LATE_MEMORIES_S))


def lost_answers(bench: Bench) -> Outcome:
    """Answers that do not come, and links that are lost, are errors; then all is well again."""
    trouble = Trouble()
    analyzer, accepted = _set_up(bench, trouble)
    for trouble.silent, trouble.drops in ((1, 0), (0, 1)):
        check_lost(refusal_of(analyzer.sweep))
        bench.relink(analyzer, accepted)
        confirmed(analyzer, 1)
    return links_serve_again()


def check_lost(refusal: Optional[VnaError]) -> None:
    """Check that a sweep whose data did not arrive was refused, and not by a promise broken."""
    if not isinstance(refusal, (VnaConnectionError, VnaTimeoutError)):
        raise refusal or NotAsPromisedError(Message("it gives data that were not transferred"))


def links_serve_again() -> Outcome:
    """Return that answers which were lost did no harm."""
    return Status.PASSED, Message("a hang and a lost link are errors; a new link serves again")


def setting_by_hand(bench: Bench) -> Outcome:
    """A setting that is changed during a sweep is noticed; whether, if it is put back."""
    trouble = Trouble()
    analyzer, accepted = _set_up(bench, trouble)
    trouble.during_sweep = ("", CHANGED)
    refusal = refusal_of(analyzer.sweep)
    if refusal is None:
        bench.pause_s(SHORTEST_MOVE_S)
        check_noticed(refusal_of(analyzer.confirm))
    trouble.during_sweep = ()
    bench.relink(analyzer, accepted)
    trouble.during_sweep = (CHANGED, PUT_BACK.format(accepted.analyzer.if_bandwidth_hz))
    return Status.PASSED, put_back(refusal_of(lambda: confirmed(analyzer, 1)) is not None)


def identity_by_hand(bench: Bench) -> Outcome:
    """Another serial number is seen at the next link; whether before."""
    trouble = Trouble()
    analyzer, _accepted = _set_up(bench, trouble)

    def replace(former: bytes, other: bytes) -> None:
        trouble.replaced = former, other

    return serial_noticed(bench, analyzer, replace)


def serial_noticed(
    bench: Bench, analyzer: Analyzer, replace: Callable[[bytes, bytes], None]
) -> Outcome:
    """Return whether an analyzer, which is set up, notices another serial number.

    Args:
        bench: Makes its links.
        analyzer: The analyzer.
        replace: Replaces something in all answers.
    """
    former = analyzer.identify()
    serial = former.split(",")[2].encode("latin-1")
    replace(serial, OTHER_SERIAL * len(serial))
    if refusal_of(lambda: confirmed(analyzer, 1)) is not None:
        return Status.PASSED, Message("another serial number is noticed at once")
    analyzer.disconnect()
    if bench.linked(analyzer) == former:
        raise NotAsPromisedError(Message("it does not notice another serial number"))
    return Status.PASSED, Message("another serial number is noticed at the next link")


CHECKS: Dict[str, Callable[[Bench], Outcome]] = {
    one.__name__: one
    for one in (
        unknown_queries,
        completion_bit,
        display_memory,
        late_flag,
        late_memory,
        lost_answers,
        setting_by_hand,
        identity_by_hand,
    )
}


def _set_up(bench: Bench, trouble: Trouble) -> Tuple[Analyzer, SweepSettings]:
    """Return an analyzer on links that go wrong, and the settings that it has confirmed."""
    analyzer = bench.made(faulty(bench.connect_vxi11, trouble, bench.clock))
    bench.linked(analyzer)
    return analyzer, analyzer.configure(bench.low)


def _only_fresh(bench: Bench, *troubles: Trouble) -> Outcome:
    """Take sweeps with each fault; none that is confirmed may be one from before."""
    # The display has as many points as the sweeps will have.
    bench.set_up(bench.low)[0].disconnect()
    refused = [_refused(bench, one) for one in troubles]
    return Status.PASSED, Message(
        "of {count} sweeps none that was confirmed is old; {refused} were refused",
        count=bench.extent.traces * len(troubles),
        refused=sum(refused),
    )


def _refused(bench: Bench, trouble: Trouble) -> int:
    """Take sweeps with a fault; return how many are refused.

    Raises:
        VnaOldDataError: One that was not refused is not what the instrument measured.
    """
    analyzer = bench.made(faulty(bench.connect_vxi11, trouble, bench.clock))
    refused, ready = 0, False
    for _ in range(bench.extent.traces):
        try:
            if not ready:
                bench.linked(analyzer)
                analyzer.configure(bench.low)
            ready = True
            sweep = analyzer.sweep()
            true = _displayed(bench, trouble.links[-1])
            bench.pause_s(SHORTEST_MOVE_S)
            analyzer.confirm()
        except VnaError:
            refused, ready = refused + 1, False
            analyzer.disconnect()
            continue
        if not (
            np.array_equal(sweep.s21_real, true[0::2])
            and np.array_equal(sweep.s21_imag, true[1::2])
        ):
            raise old_data()
    analyzer.disconnect()
    return refused


def _displayed(bench: Bench, link: Transport) -> np.ndarray:
    """Return what the instrument really shows [real and imaginary part in turn]."""
    parameters = bench.parameters
    return parse_numbers(
        link.ask_raw(DATA_QUERY), parameters.transfer_format, 2 * bench.extent.points
    )


@contextlib.contextmanager
def _link(bench: Bench) -> Iterator[Transport]:
    link = bench.connect_vxi11(bench.parameters.address)
    try:
        yield link
    finally:
        link.close()


def _watched(bench: Bench, lag_s: float) -> List[Tuple[float, float, float]]:
    """Watch sweeps; return of each how long the bit was stale, its end, and the lag of its data."""
    analyzer, _accepted = bench.set_up(bench.low)
    duration_s = analyzer.trace_duration_s or 0.0
    analyzer.disconnect()
    with _link(bench) as link:
        return [_watch(bench, link, duration_s, lag_s) for _ in range(WATCHED_SWEEPS)]


def _watch(
    bench: Bench, link: Transport, duration_s: float, lag_s: float
) -> Tuple[float, float, float]:
    now_s = bench.clock.now_s
    before = link.ask_raw(DATA_QUERY)
    link.write(TRIGGER)
    begun_s = now_s()
    stale_s, cleared = 0.0, False
    while True:
        bench.deadline.check()
        ended = is_complete(link.ask_raw(STATUS_QUERY))
        elapsed_s = now_s() - begun_s
        if ended and (cleared or elapsed_s > 2.0 * duration_s):
            break
        cleared = cleared or not ended
        stale_s = stale_s if cleared else elapsed_s
    ended_s = changed_s = now_s()
    shown = before
    while now_s() - ended_s < lag_s:
        read = link.ask_raw(DATA_QUERY)
        if read != shown:
            shown, changed_s = read, now_s()
    return stale_s, ended_s - begun_s, changed_s - ended_s
