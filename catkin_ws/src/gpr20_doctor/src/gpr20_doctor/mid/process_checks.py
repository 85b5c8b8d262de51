"""Checks of what runs on this computer, and of its memory."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, Iterator, List

from gpr20_common.faults import INTERNAL, OVERLOADED, PART_LOST
from gpr20_common.message import Message, verbatim
from gpr20_doctor.low.processes import HALTED, Process
from gpr20_doctor.mid.finding import Finding
from gpr20_doctor.mid.machine import Machine
from gpr20_doctor.mid.node_health import EXPECTED_NODES, node_title

MB, BYTES_PER_KB = 1e6, 1024
# Below them the system begins to end programs [bytes].
LOW_MEMORY, NO_MEMORY = 200e6, 80e6
# Nodes whose hang the checks of reports find; a hung one must not simply be continued.
OWN_REPORT = frozenset(name.rpartition("/")[2] for name in EXPECTED_NODES)


def check_launch(machine: Machine) -> Iterator[Finding]:
    """Find parts of the robot that nobody would start again."""
    nodes = machine.processes.nodes_of(machine.master)
    left = [one for one in nodes if one.master and machine.processes.is_left_over(one)]
    launches = machine.processes.launches_of(machine.master)
    if left:
        text = Message(
            "The launch of {count} parts of the robot on this computer has ended. They run on, "
            "and nothing starts one of them again if it ends.",
            count=len(left),
        )
        advice = Message(
            "Run: kill {numbers}. A survey that runs is stopped and can be resumed. Then start the "
            "robot again.",
            numbers=_numbers(left),
        )
        yield Finding.of("launch", text, INTERNAL, mild=True, advice=machine.restart(advice))
    others = [one for one in nodes if one.node not in OWN_REPORT]
    halted = [one for one in (*launches, *others) if one.state in HALTED]
    if halted:
        names = tuple(node_title(one.node) if one.node else verbatim("roslaunch") for one in halted)
        text = Message("Stopped on this computer, and does nothing: {parts}", parts=names)
        advice = Message(
            "Run: kill -CONT {numbers}. If it is found again, start the robot again.",
            numbers=_numbers(halted),
        )
        yield Finding.of("launch", text, PART_LOST, advice=advice)
    if launches and not left + halted:
        yield Finding.of("launch", Message("Launch of the robot on this computer"))


def check_watchdog(machine: Machine) -> Iterator[Finding]:
    """Judge whether each launch has what would end its parts that hang; it may be stopped."""
    known = machine.processes
    nodes = [one for one in known.nodes_of(machine.master) if not known.is_left_over(one)]
    launches = {one.argument("configuration:=") for one in nodes} - {""}
    watched = {one.argument("--launch=") for one in nodes}
    if launches - watched:
        text = Message("No watchdog runs here: a part of the robot that hangs is not restarted.")
        yield Finding.of("watchdog", text, INTERNAL, True, machine.restart(WITH_WATCHDOG))
    elif launches:
        yield Finding.of("watchdog", Message("Watchdog"))


WITH_WATCHDOG = Message("Start the robot again, with watchdog_s:=10 or without that argument.")


def check_memory(machine: Machine) -> Iterator[Finding]:
    """Judge the memory that programs may still have."""
    free = _sizes(machine.root / "proc/meminfo")["MemAvailable"] * BYTES_PER_KB
    ended = _sizes(machine.root / "proc/vmstat").get("oom_kill", 0)
    text = Message("Memory: {free_mb:.0f} MB free", free_mb=free / MB)
    advice = Message(
        "End other programs on this computer; to see them, run: ps aux --sort=-rss | head"
    )
    if free >= LOW_MEMORY and ended:
        text = Message(
            "Linux has ended {count} programs for lack of memory since the start.", count=ended
        )
        advice = Message(
            "Note which program was ended: sudo dmesg | grep -i oom. Then restart the computer, "
            "and run nothing else beside the robot."
        )
    fault = OVERLOADED if free < LOW_MEMORY or ended else None
    yield Finding.of("memory", text, fault, mild=free >= NO_MEMORY, advice=advice)


def _numbers(some: List[Process]) -> str:
    return " ".join(map(str, sorted(one.number for one in some)))


def _sizes(path: Path) -> Dict[str, int]:
    rows = (line.replace(":", " ").split() for line in path.read_text().splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1}
