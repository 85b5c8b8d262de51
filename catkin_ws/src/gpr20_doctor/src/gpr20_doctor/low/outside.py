"""Whether a foreign computer reaches ports of this one: tried in a network of its own, not read.

A process in a network namespace has an address that nobody uses (RFC 5737) and a link to this
computer alone. What it sends passes the same rules as what comes by a cable. Namespace and link
end with that process, however the doctor ends.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import socket
import subprocess
import sys
from typing import Iterator, List, Sequence, Tuple

STRANGER, HERE, ANYWHERE = "192.0.2.2", "192.0.2.1", "0.0.0.0"
LIMIT_S = 10.0
ATTEMPT_S = 1.5
NOT_ROOT = "only root may try it"
# First it says that its network is there, then where it listens, then which ports it reached.
PROBE = """
import json, socket, subprocess, sys
from concurrent.futures import ThreadPoolExecutor
stranger, here, limit_s = sys.argv[1], sys.argv[2], float(sys.argv[3])
print("ready", flush=True)
link, targets = json.loads(sys.stdin.readline())
for words in (["addr", "add", stranger + "/30", "dev", link], ["link", "set", link, "up"],
              ["route", "add", "default", "via", here]):
    subprocess.run(["ip", *words], check=True)
with socket.create_server((stranger, 0)) as server:
    print(server.getsockname()[1], flush=True)
    sys.stdin.readline()
def reaches(target):
    try:
        socket.create_connection(tuple(target), limit_s).close()
    except OSError:
        return False
    return True
with ThreadPoolExecutor(max(1, len(targets))) as pool:
    print(json.dumps([one for one, yes in zip(targets, pool.map(reaches, targets)) if yes]))
"""


def reached_from_outside(
    addresses: Sequence[str], targets: Sequence[Tuple[str, int]]
) -> List[Tuple[str, int]]:
    """Return which ports a foreign computer reaches.

    Args:
        addresses: IPv4 addresses of this computer, on which a port of our own is tried.
        targets: Addresses and ports where something listens, which are tried too.

    Raises:
        OSError: It cannot be tried here; the text says why.
    """
    if os.geteuid() != 0:
        raise PermissionError(NOT_ROOT)
    if shutil.which("ip") is None or shutil.which("unshare") is None:
        raise FileNotFoundError("no ip or unshare")
    with contextlib.ExitStack() as stack:
        own = [stack.enter_context(_listener(one)) for one in addresses]
        wanted = [(HERE if host == ANYWHERE else host, port) for host, port in (*targets, *own)]
        probe = stack.enter_context(_probe())
        try:
            return _try(probe, wanted)
        except (subprocess.SubprocessError, ValueError) as error:
            printed = getattr(error, "stderr", None) or str(error)
            raise OSError(printed.strip()) from error


def _try(probe: subprocess.Popen, wanted: Sequence[Tuple[str, int]]) -> List[Tuple[str, int]]:
    _line(probe)
    link = f"gpr20-{probe.pid}"
    peer = ["type", "veth", "peer", "name", link, "netns", str(probe.pid)]
    for words in (
        ["link", "add", link, *peer],
        ["addr", "add", f"{HERE}/30", "dev", link],
        ["link", "set", link, "up"],
    ):
        subprocess.run(
            ["ip", *words], check=True, timeout=LIMIT_S, stderr=subprocess.PIPE, text=True
        )
    _say(probe, json.dumps([link, wanted]))
    port = int(_line(probe))
    # Rules that shut out strangers let answers through: without this one the link does not work.
    socket.create_connection((STRANGER, port), ATTEMPT_S).close()
    _say(probe, "")
    return [(host, port) for host, port in json.loads(_line(probe))]


@contextlib.contextmanager
def _probe() -> Iterator[subprocess.Popen]:
    command = ["unshare", "--net", sys.executable, "-c", PROBE, STRANGER, HERE, str(ATTEMPT_S)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as probe:
        try:
            yield probe
        finally:
            probe.kill()


@contextlib.contextmanager
def _listener(address: str) -> Iterator[Tuple[str, int]]:
    with socket.create_server((address, 0)) as server:
        yield address, server.getsockname()[1]


def _say(probe: subprocess.Popen, line: str) -> None:
    assert probe.stdin is not None
    try:
        probe.stdin.write(f"{line}\n")
        probe.stdin.flush()
    except BrokenPipeError as error:
        raise OSError(_last_words(probe)) from error


def _line(probe: subprocess.Popen) -> str:
    assert probe.stdout is not None
    line = probe.stdout.readline()
    if not line:
        raise OSError(_last_words(probe))
    return str(line)


def _last_words(probe: subprocess.Popen) -> str:
    _out, printed = probe.communicate(timeout=LIMIT_S)
    return (printed.strip().splitlines() or ["it ended"])[-1]
