"""check_analyzer: shows what an analyzer really does, and whether a survey can rely on it."""

from __future__ import annotations

import argparse
import os
import sys
import threading
from pathlib import Path
from typing import Callable, List, Sequence

import rosgraph

from gpr20_common.errors import Gpr20Error, os_reason
from gpr20_common.low.yaml_file import configured, robot_folder
from gpr20_common.message import Message
from gpr20_common.mid.codec import record_from
from gpr20_common.terminal_text import say
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, Vxi11Transport, connect
from gpr20_vna_acquisition.mid.analyzers import Result, passed, store
from gpr20_vna_acquisition.mid.conformance import Bench, Extent, results
from gpr20_vna_acquisition.mid.exchanges import WATCH_PERIOD_S, RequestDeadline
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

FILE = "analyzer.yaml"
BEGIN = (
    "The check takes about one minute. It changes the VNA's settings, which can end its "
    "calibration. No robot may use the VNA meanwhile."
)


def main() -> int:
    """Check the analyzer of the configuration."""
    given = _parser().parse_args(rosgraph.myargv()[1:])
    folder = given.config.expanduser().absolute()
    try:
        parameters = record_from(VnaParameters, configured(folder / FILE), "")
        ask = _ask if given.by_hand else None
        found = check(Bench(parameters, _connector(parameters), Extent(), ask))
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


def check(bench: Bench) -> Sequence[Result]:
    """Make every check of an analyzer and print its result."""
    say(BEGIN, flush=True)
    found: List[Result] = []
    # A class of others may make a call that does not return.
    ended = threading.Event()
    threading.Thread(target=_watch, args=(bench.deadline, ended), daemon=True).start()
    for one in results(bench):
        status = one.status.name.replace("_", " ")
        text = " ".join((one.text.sentence(), *(f"({part})" for part in one.text.all_details)))
        say(f"{status:12}{one.check:21}{text}", flush=True)
        found.append(one)
    ended.set()
    say("PASSED" if passed(found) else "FAILED", flush=True)
    return found


def _watch(deadline: RequestDeadline, ended: threading.Event) -> None:
    while not ended.wait(WATCH_PERIOD_S):
        deadline.end_if_overdue(lambda text: say(f"FAILED: {text}", flush=True))


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "check_analyzer",
        description=__doc__,
        epilog="exit status: 0 no check failed, 1 one failed or nothing could be checked",
    )
    parser.add_argument(
        "--config",
        type=Path,
        default=robot_folder(os.environ),
        help="folder of the robot's configuration",
    )
    parser.add_argument(
        "--by-hand", action="store_true", help="also ask to take a cable off the VNA"
    )
    return parser


def _connector(parameters: VnaParameters) -> Callable[[str], Vxi11Transport]:
    limits = LinkLimits(parameters.connect_timeout_s, parameters.answer_timeout_s)
    return lambda address: connect(address, limits, parameters.vxi11_port or None)


def _ask(text: Message) -> None:
    input(f"{text} ")
