"""A simulated drive of one axis that takes lines of text on a TCP port.

The endstop closes 1 mm below the place where the carriage rests after homing.
"""

from __future__ import annotations

import contextlib
import math
import socket
import threading
import time
from typing import Optional

SPEED_STEPS_S = 1000.0
HOMING_STEPS_S = 6000.0
PULL_OFF_STEPS = 100
MOST_HOMING_STEPS = 4000
# Without a line for this time a move ends [s].
SILENT_S = 1.5
TICK_S = 0.002
# A busy computer makes it slow, and lets it leap nowhere.
LONGEST_TICK_S = 0.02


class LineDrive:
    """Moves its carriage, whether a client is connected or not.

    Attributes:
        port: Its TCP port.
        plugged: Whether a client is served; else its connection is closed, as is every new one.
        jammed: Whether the endstop stays pressed (True) or open (False).
        homed: Whether it knows its zero.
        lost_steps: How far before its target a move ends.
        answering: Cleared, no line is answered.
        moves: How many moves were begun.
    """

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._listener.settimeout(TICK_S)
        self.port = self._listener.getsockname()[1]
        self.jammed: Optional[bool] = None
        self.plugged, self.homed, self.lost_steps = True, False, 0
        self.answering, self.moves, self._open = threading.Event(), 0, True
        self.answering.set()
        self._steps, self._target, self._sought = 500.0, 500.0, 0.0
        self._homing, self._lock = "", threading.Lock()
        self._moved_s = self._asked_s = time.monotonic()
        self._threads = [threading.Thread(target=one) for one in (self._serve, self._move)]
        for thread in self._threads:
            thread.start()

    @property
    def true_steps(self) -> int:
        """Where the carriage is."""
        return round(self._steps)

    def close(self) -> None:
        self._open = False
        for thread in self._threads:
            thread.join()
        self._listener.close()

    def _serve(self) -> None:
        while self._open:
            with contextlib.suppress(OSError):  # nobody connects, or somebody has gone
                client, _address = self._listener.accept()
                with client, client.makefile("r") as lines:
                    while self.plugged and (line := lines.readline()):
                        with self._lock:
                            self._asked_s = time.monotonic()
                            answer = self._answer(*line.split())
                        self.answering.wait()
                        client.sendall(answer.encode() + b"\n")

    def _answer(self, command: str, steps: str = "0") -> str:
        if command == "state":
            moving = self._homing or self._target != self._steps
            state = (self.true_steps, bool(moving), self.homed, self._pressed)
            return " ".join(str(int(one)) for one in state)
        if command == "move":
            self._target, self.moves = float(steps) - self.lost_steps, self.moves + 1
        elif command == "home":
            self._homing, self.homed, self._sought = "seek", False, 0.0
        else:
            self._homing, self._target = "", float(self.true_steps)
        return "ok"

    @property
    def _pressed(self) -> bool:
        return self._steps <= -PULL_OFF_STEPS if self.jammed is None else self.jammed

    def _move(self) -> None:
        while self._open:
            time.sleep(TICK_S)
            with self._lock:
                before_s, self._moved_s = self._moved_s, time.monotonic()
                self._tick(min(LONGEST_TICK_S, self._moved_s - before_s))

    def _tick(self, time_s: float) -> None:
        if self._homing:
            self._home(HOMING_STEPS_S * time_s)
        elif self._moved_s - self._asked_s > SILENT_S:
            self._answer("stop")
        rest = self._target - self._steps
        self._steps += math.copysign(min(abs(rest), SPEED_STEPS_S * time_s), rest)

    def _home(self, steps: float) -> None:
        if self._homing == "back off":
            self._steps = min(0.0, self._steps + steps)
            self.homed = self._steps == 0.0
        elif self._pressed:
            self._homing = "back off"
        else:
            self._sought += steps
            self._steps = max(-float(PULL_OFF_STEPS), self._steps - steps)
        if self.homed or self._sought > MOST_HOMING_STEPS:
            self._homing = ""
        self._target = self._steps
