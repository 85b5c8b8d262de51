"""check_analyzer: shows what an analyzer really does, and whether a survey can rely on it."""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, List, Optional, Sequence, Tuple

import rosgraph
import yaml

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.data_folder import configured, robot_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import say
from gpr20_vna_acquisition.low.tcp_relay import ADDRESS, TcpRelay
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, Vxi11Transport, connect
from gpr20_vna_acquisition.mid.conformance.bench import Bench, Extent
from gpr20_vna_acquisition.mid.conformance.record import store
from gpr20_vna_acquisition.mid.conformance.suite import Ask, Result, line, passed, results
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

FILE = "analyzer.yaml"
BEGIN = (
    "The check takes about one minute. It changes the VNA's settings, which can end its "
    "calibration. No robot may use the VNA meanwhile."
)


def main() -> int:
    """Check the analyzer that the command line or the configuration names."""
    given = _parser().parse_args(rosgraph.myargv()[1:])
    folder = given.config.expanduser().absolute()
    try:
        parameters = _parameters(folder, given)
        found = _checked(parameters, given)
        if len(found) == 1:
            return 1  # no right instrument answers: that says nothing of the class
        path = store(folder, parameters, found)
    except Gpr20Error as error:
        say(f"check_analyzer: {error.message.sentence()}", file=sys.stderr)
        return 1
    except OSError as error:
        say(f"check_analyzer: {folder}: {os_reason(error).sentence()}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 1
    say(f"stored in {path}")
    return 0 if passed(found) else 1


def _checked(parameters: VnaParameters, given: argparse.Namespace) -> Sequence[Result]:
    ask = _ask if given.by_hand else None
    if not given.relay:
        return check(Bench(parameters, _connector(parameters), Extent()), ask)
    host, port = given.relay
    with TcpRelay(host, port) as relay:
        relayed = replace(parameters, address=parameters.address.replace(host, ADDRESS))
        return check(Bench(relayed, _connector(relayed), Extent()), ask, relay)


def check(bench: Bench, ask: Optional[Ask], relay: Optional[TcpRelay] = None) -> Sequence[Result]:
    """Make every check and print its result.

    Args:
        bench: The analyzer.
        ask: Asks a person to do something and returns when it is done; None: nobody is there.
        relay: Passes on what a class and its instrument say; None: they speak directly.
    """
    say(BEGIN, flush=True)
    found: List[Result] = []
    for one in results(bench, ask, relay):
        say(line(one), flush=True)
        found.append(one)
    say("PASSED" if passed(found) else "FAILED", flush=True)
    return found


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "check_analyzer",
        description=__doc__,
        epilog="exit status: 0 no check failed, 1 one failed or nothing could be checked",
    )
    parser.add_argument(
        "analyzer",
        nargs="?",
        help="ms2026c, or a class as package.module:Class; default: that of the configuration",
    )
    parser.add_argument(
        "--config",
        type=Path,
        default=robot_folder(os.environ),
        help="folder of the robot's configuration",
    )
    parser.add_argument(
        "--set",
        type=_pair,
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="another value of a key of analyzer.yaml, such as address=192.168.1.5",
    )
    parser.add_argument(
        "--by-hand", action="store_true", help="also ask to take a cable off the VNA"
    )
    parser.add_argument(
        "--relay",
        type=_host_and_port,
        metavar="HOST:PORT",
        help="only for a class that uses one TCP port: where the instrument is; its answers are "
        "passed on by this program, which also loses and changes some",
    )
    return parser


def _host_and_port(text: str) -> Tuple[str, int]:
    host, _colon, port = text.rpartition(":")
    if not host or not port.isdigit():
        raise argparse.ArgumentTypeError("give HOST:PORT")
    return host, int(port)


def _pair(text: str) -> Tuple[str, Any]:
    key, equals, value = text.partition("=")
    try:
        if equals:
            return key, yaml.safe_load(value)
    except yaml.YAMLError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    raise argparse.ArgumentTypeError("give KEY=VALUE")


def _parameters(folder: Path, given: argparse.Namespace) -> VnaParameters:
    values = configured(folder / FILE)
    if given.analyzer and given.analyzer != values.get("analyzer"):
        values.pop("analyzer_options", None)
        values["analyzer"] = given.analyzer
    values.update(given.set)
    return record_from(VnaParameters, values, "")


def _connector(parameters: VnaParameters) -> Callable[[str], Vxi11Transport]:
    limits = LinkLimits(parameters.connect_timeout_s, parameters.answer_timeout_s)
    return lambda address: connect(address, limits, parameters.vxi11_port or None)


def _ask(text: Message) -> None:
    input(f"{text} ")
