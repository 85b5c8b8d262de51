"""Where the processes of a running system can be reached."""

from __future__ import annotations

import psutil


def processes_below(*parents):
    """Return the command lines of these processes and of all that came from them, by process."""
    found = {}
    for parent in parents:
        root = psutil.Process(parent.pid)
        for process in [root, *root.children(recursive=True)]:
            try:
                found[process] = " ".join(process.cmdline())
            except (psutil.NoSuchProcess, psutil.ZombieProcess):
                continue
    return found


def reachable_at(processes):
    """Yield (command line, address) of everything that listens by TCP or receives by UDP."""
    for process, command_line in processes.items():
        try:
            connections = process.net_connections(kind="inet")
        except (psutil.NoSuchProcess, psutil.ZombieProcess):
            continue
        for one in connections:
            if one.status in (psutil.CONN_LISTEN, psutil.CONN_NONE) and one.laddr:
                yield command_line, one.laddr.ip
