"""Checks of a class that speaks to one TCP port, by a relay that loses and changes its answers."""

from __future__ import annotations

import functools
from typing import Callable, Dict

from gpr20_vna_acquisition.low.tcp_relay import TcpRelay
from gpr20_vna_acquisition.mid.conformance.bench import Bench, Outcome, confirmed, refusal_of
from gpr20_vna_acquisition.mid.conformance.wire_checks import (
    check_lost,
    links_serve_again,
    serial_noticed,
)

# A request whose answer does not come is given up after this time [s].
HANG_LIMIT_S = 5.0


def lost_answers(bench: Bench, relay: TcpRelay) -> Outcome:
    """Answers that do not come, and links that are lost, are errors; then all is well again."""
    analyzer, accepted = bench.set_up(bench.low)
    for hangs in (True, False):
        bench.deadline.begin(min(HANG_LIMIT_S, bench.extent.limit_s))
        relay.silent = hangs
        if not hangs:
            relay.drop()
        refusal = refusal_of(analyzer.sweep)
        relay.silent = False
        check_lost(refusal)
        bench.begin()
        bench.relink(analyzer, accepted)
        confirmed(analyzer, 1)
    return links_serve_again()


def identity_by_hand(bench: Bench, relay: TcpRelay) -> Outcome:
    """Another serial number is seen at the next link; whether before."""
    analyzer, _accepted = bench.set_up(bench.low)

    def replace(former: bytes, other: bytes) -> None:
        relay.replaced = former, other

    try:
        return serial_noticed(bench, analyzer, replace)
    finally:
        replace(b"", b"")


NAMES = (lost_answers.__name__, identity_by_hand.__name__)


def checks(relay: TcpRelay) -> Dict[str, Callable[[Bench], Outcome]]:
    """Return the checks with a relay between the class and the instrument."""
    return {
        one.__name__: functools.partial(one, relay=relay)
        for one in (lost_answers, identity_by_hand)
    }
