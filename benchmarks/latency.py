"""What a trace costs beyond its sweep on an instrument that takes its time for every message.

    scripts/bench.sh latency [--message-ms 20] [--workspace DIR --workspace DIR] [--json FILE]

Launches the simulated robot at its real speed, with an instrument that takes 20 ms for each
message, and runs a survey of 501 points (0.175 s). Of each trace are measured the duration of
`get_data` without the sweep, and the messages that reach the instrument from the request of the
sweep, at rest, to the first goal of the next move, and from one request to the next.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Dict, List, Sequence

from graph_kit import (
    Event,
    arguments,
    events,
    finish,
    intervals,
    launched,
    median,
    print_table,
    run_survey,
    workspaces,
)

POINTS = 501
SECONDS_PER_POINT = 350e-6
SWEEP_S = POINTS * SECONDS_PER_POINT
STEP_MM = 0.1
ROWS = 3
# The first traces follow the set-up.
WARM_UP = 2
Figures = Dict[str, List[float]]


def figures_of(noted: Sequence[Event]) -> Figures:
    """Return what was found at each trace; times in s."""
    serves = intervals(noted, "serve", "get_data")
    confirms = intervals(noted, "serve", "confirm_data")
    calls = intervals(noted, "call", "get_data")
    goals = intervals(noted, "goal", "")
    messages = [event.time_s for event in noted if event.kind == "message" and event.phase == "B"]
    found: Figures = {
        "beyond_sweep_s": [],
        "confirm_s": [],
        "messages_at_rest": [],
        "messages": [],
        "at_rest_s": [],
    }

    def count(begin_s: float, end_s: float) -> int:
        return sum(1 for one in messages if begin_s <= one < end_s)

    for (asked_s, _), (next_s, _) in zip(calls[WARM_UP:], calls[WARM_UP + 1 :]):
        after = [begin for begin, _end in goals if asked_s <= begin < next_s]
        if not after:
            continue
        found["messages_at_rest"].append(count(asked_s, min(after)))
        found["messages"].append(count(asked_s, next_s))
        found["at_rest_s"].append(min(after) - asked_s)
        found["beyond_sweep_s"] += [
            end - begin - SWEEP_S for begin, end in serves if asked_s <= begin < next_s
        ]
        found["confirm_s"] += [end - begin for begin, end in confirms if asked_s <= begin < next_s]
    return found


def measure(root: Path, chosen: argparse.Namespace) -> Figures:
    """Run one survey."""
    options = ("time_scale:=1", f"seconds_per_point:={SECONDS_PER_POINT}")
    with launched(root, *options, tap=True, message_ms=chosen.message_ms) as robot:
        run_survey(
            robot,
            *("--x-start-mm=10", f"--x-stop-mm={10 + STEP_MM * (chosen.columns - 1):g}"),
            *(f"--x-points={chosen.columns}", "--y-start-mm=10"),
            *(f"--y-stop-mm={10 + STEP_MM * (ROWS - 1):g}", f"--y-points={ROWS}"),
            *("--polarizations-deg=0", f"--frequency-points={POINTS}"),
        )
        return figures_of(events(robot))


def main() -> None:
    parser = arguments(__doc__ or "")
    parser.add_argument("--columns", type=int, default=10, help="stops of each of 3 rows (10)")
    parser.add_argument("--message-ms", type=float, default=20.0, help="time of a message (20)")
    chosen = parser.parse_args()
    merged: Dict[str, Figures] = {}
    for number in range(chosen.rounds):
        for root in workspaces(chosen):
            found = measure(root, chosen)
            beyond_ms = 1e3 * median(found["beyond_sweep_s"])
            print(f"round {number + 1}: {root}: {beyond_ms:.0f} ms beyond the sweep", flush=True)
            total = merged.setdefault(str(root), {name: [] for name in found})
            for name, values in found.items():
                total[name] += values
    print(f"\nmedians; the instrument takes {chosen.message_ms:g} ms for each message")
    print_table(
        [
            *("checkout", "traces", "get_data beyond the sweep ms", "confirm_data ms"),
            *("messages from request to move", "messages per trace"),
        ],
        [
            [
                label,
                str(len(found["at_rest_s"])),
                *(f"{1e3 * median(found[name]):.0f}" for name in ("beyond_sweep_s", "confirm_s")),
                *(f"{median(found[name]):.0f}" for name in ("messages_at_rest", "messages")),
            ]
            for label, found in merged.items()
        ],
    )
    figures = {
        label: {name: median(values) for name, values in found.items()}
        for label, found in merged.items()
    }
    finish(chosen, {"benchmark": "latency", "message_ms": chosen.message_ms, "figures": figures})


if __name__ == "__main__":
    main()
