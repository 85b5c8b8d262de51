"""All checks of an analyzer, one after the other, and the table of their results."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Callable, Dict, Iterator, Optional, Sequence

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Message
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaIdentityError, VnaTimeoutError
from gpr20_vna_acquisition.low.tcp_relay import TcpRelay
from gpr20_vna_acquisition.mid.conformance import protocol_checks, relay_checks, wire_checks
from gpr20_vna_acquisition.mid.conformance.bench import Bench, Outcome, Status
from gpr20_vna_acquisition.mid.vna_parameters import MS2026C

STATUS_WIDTH, CHECK_WIDTH = 12, 21
FIRST = protocol_checks.identity.__name__
# Without a right instrument that answers, nothing else can be checked.
HOPELESS = (VnaConnectionError, VnaIdentityError, VnaTimeoutError)
Check = Callable[[Bench], Outcome]
Ask = Callable[[Message], None]


@dataclass(frozen=True)
class Result:
    """The result of one check.

    Attributes:
        check: Name of the check, for programs.
        status: How it ended.
        text: What was found.
    """

    check: str
    status: Status
    text: Message


def results(
    bench: Bench, ask: Optional[Ask] = None, relay: Optional[TcpRelay] = None
) -> Iterator[Result]:
    """Make every check and yield its result.

    Args:
        bench: The analyzer.
        ask: Asks a person to do something and returns when it is done; None: nobody is there.
        relay: Passes on what the class and the instrument say; None: they speak directly.
    """
    for name, check in _checks(bench, ask, relay).items():
        bench.begin()
        try:
            status, text = check(bench)
        except Gpr20Error as error:
            status, text = Status.FAILED, error.message
            if name == FIRST and isinstance(error, HOPELESS):
                yield Result(name, status, text)
                return
        finally:
            bench.clear()
        yield Result(name, status, text)


def passed(found: Sequence[Result]) -> bool:
    """Return whether no check failed."""
    return bool(found) and all(one.status is not Status.FAILED for one in found)


def line(result: Result) -> str:
    """Return the line of a result in the table."""
    status = result.status.name.replace("_", " ")
    text = " ".join((result.text.sentence(), *(f"({one})" for one in result.text.all_details)))
    return f"{status:{STATUS_WIDTH}}{result.check:{CHECK_WIDTH}}{text}"


def _checks(bench: Bench, ask: Optional[Ask], relay: Optional[TcpRelay]) -> Dict[str, Check]:
    checks: Dict[str, Check] = dict(protocol_checks.CHECKS)
    if bench.parameters.analyzer == MS2026C:
        checks.update(wire_checks.CHECKS)
    else:
        checks.update(dict.fromkeys(wire_checks.CHECKS, _needs_messages))
        given = relay_checks.checks(relay) if relay else {}
        checks.update(given or dict.fromkeys(relay_checks.NAMES, _needs_a_relay))
    checks["by_hand"] = (
        _needs_a_person if ask is None else functools.partial(protocol_checks.by_hand, ask=ask)
    )
    return checks


def _needs_messages(_bench: Bench) -> Outcome:
    return Status.NOT_TESTED, Message("only the messages of the MS2026C are known")


def _needs_a_relay(_bench: Bench) -> Outcome:
    return Status.NOT_TESTED, Message("a relay is needed: give --relay HOST:PORT")


def _needs_a_person(_bench: Bench) -> Outcome:
    return Status.NOT_TESTED, Message("a person is needed: give --by-hand")
