"""Notes when the nodes of a launched robot call each other; loaded by every Python process.

Python imports a module of this name at its start. `graph_kit` puts this folder in front of the
search path of a launch; nothing of the product knows about it. Each event is one line of the file
that GPR20_TAP names: time [ns of the monotonic clock], process, kind, name, begin or end.
"""

from __future__ import annotations

import functools
import importlib.machinery
import os
import sys
import time
from types import ModuleType
from typing import Any, Callable, Dict, Optional, Sequence

BEGIN, END = "B", "E"


class Tap:
    """Appends events to the file; one write each, so that those of all processes stay whole."""

    def __init__(self, path: str) -> None:
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o600)

    def note(self, kind: str, name: str, phase: str) -> None:
        """Append one event."""
        line = f"{time.monotonic_ns()}\t{os.getpid()}\t{kind}\t{name}\t{phase}\n"
        os.write(self._file, line.encode())

    def around(self, kind: str, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that notes its begin and its end."""

        @functools.wraps(function)
        def noted(*arguments: Any, **fields: Any) -> Any:
            self.note(kind, name, BEGIN)
            try:
                return function(*arguments, **fields)
            finally:
                self.note(kind, name, END)

        return noted


def tap_clients(tap: Tap, module: ModuleType) -> None:
    """Note each call of a service, in the process that calls it."""
    client = module.ServiceClient
    call = client.call

    @functools.wraps(call)
    def noted(self: Any, *arguments: Any, **fields: Any) -> Any:
        return tap.around("call", self.name, functools.partial(call, self))(*arguments, **fields)

    client.call = noted


def tap_action_client(tap: Tap, module: ModuleType) -> None:
    """Note when a goal is sent, and when its result has come."""
    client = module.ActionClient
    send = client.send_goal

    @functools.wraps(send)
    def noted(self: Any, goal: Any, transition_cb: Any = None, feedback_cb: Any = None) -> Any:
        def transition(handle: Any) -> None:
            if handle.get_comm_state() == module.CommState.DONE:
                tap.note("goal", self.ns, END)
            if transition_cb is not None:
                transition_cb(handle)

        tap.note("goal", self.ns, BEGIN)
        return send(self, goal, transition, feedback_cb)

    client.send_goal = noted


def tap_storage(tap: Tap, module: ModuleType) -> None:
    """Note the writing of a trace, on the storage's thread."""
    module.OpenSurvey.store = tap.around("write", "trace", module.OpenSurvey.store)


TAPS: Dict[str, Callable[[Tap, ModuleType], None]] = {
    "gpr20_common.high.service_client": tap_clients,
    "actionlib.action_client": tap_action_client,
    "gpr20_vna_processing.mid.open_survey": tap_storage,
}


class TappingFinder:
    """Finds the modules of TAPS as Python does, and taps each when it has been loaded."""

    def __init__(self, tap: Tap) -> None:
        self._tap = tap

    def find_spec(
        self, name: str, path: Optional[Sequence[str]] = None, target: Optional[ModuleType] = None
    ) -> Optional[importlib.machinery.ModuleSpec]:
        """Return how a module is loaded; None if it is not one of TAPS."""
        add = TAPS.get(name)
        spec = importlib.machinery.PathFinder.find_spec(name, path, target) if add else None
        if add is None or spec is None or spec.loader is None:
            return None
        execute = spec.loader.exec_module

        def execute_and_tap(module: ModuleType) -> None:
            execute(module)
            add(self._tap, module)

        spec.loader.exec_module = execute_and_tap  # type: ignore[method-assign]
        return spec


if "GPR20_TAP" in os.environ:
    sys.meta_path.insert(0, TappingFinder(Tap(os.environ["GPR20_TAP"])))  # type: ignore[arg-type]
