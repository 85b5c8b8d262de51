"""A simulated board with GRBL 1.1 and one axis, on a TCP port: as much of it as an axis needs.

The endstop closes 1 mm below the place where the carriage rests after homing.
"""

from __future__ import annotations

import math
import socket
import threading
import time
from typing import Optional

STEP_MM = 0.01
PULL_OFF_MM = 1.0
HOMING_MM_S = 60.0
MOST_HOMING_MM = 40.0
TICK_S = 0.002
GREETING = b"Grbl 1.1h ['$' for help]\r\n"


class GrblBoard:
    """Moves its carriage in a thread of its own, whether a client is connected or not.

    Attributes:
        port: Its TCP port.
        jammed: Whether the endstop stays pressed (True) or open (False).
    """

    def __init__(self) -> None:
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.jammed: Optional[bool] = None
        self._lock = threading.Lock()
        self._client: Optional[socket.socket] = None
        self._plugged, self._open = True, True
        self._place_mm = 5.0  # of the carriage, from the zero that homing finds
        self._offset_mm = -12.34  # of the board's own coordinates
        self._feed_mm_s = 0.0
        self._target_mm: Optional[float] = None
        self._homing = ""
        self._homed_mm = 0.0
        self._alarm = True
        self._threads = [threading.Thread(target=one) for one in (self._serve, self._move)]
        for thread in self._threads:
            thread.start()

    @property
    def true_steps(self) -> int:
        """Where the carriage is."""
        return round(self._place_mm / STEP_MM)

    def unplug(self) -> None:
        """Close the connection and refuse others."""
        with self._lock:
            self._plugged = False
            self._drop()

    def plug_in(self) -> None:
        with self._lock:
            self._plugged = True

    def close(self) -> None:
        self._open = False
        self.unplug()
        for thread in self._threads:
            thread.join()
        self._listener.close()

    def _drop(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def _serve(self) -> None:
        self._listener.settimeout(0.05)
        while self._open:
            try:
                client, _address = self._listener.accept()
            except socket.timeout:
                continue
            if not self._plugged:
                client.close()
                continue
            self._client = client
            threading.Thread(target=self._read, args=(client,), daemon=True).start()

    def _read(self, client: socket.socket) -> None:
        line = b""
        while True:
            try:
                data = client.recv(256)
            except OSError:
                return
            if not data:
                return
            for byte in (bytes([one]) for one in data):
                with self._lock:
                    if byte == b"\n":
                        self._execute(line.decode("ascii").strip())
                        line = b""
                    elif byte in (b"?", b"\x18", b"\x85", b"!", b"~"):
                        self._realtime(byte)
                    else:
                        line += byte

    def _send(self, data: bytes) -> None:
        if self._client is not None:
            try:
                self._client.sendall(data)
            except OSError:
                self._client = None

    def _realtime(self, byte: bytes) -> None:
        if byte == b"\x18":
            if self._homing:
                self._send(b"ALARM:6\r\n")
            self._alarm = bool(self._homing) or self._alarm
            self._homing, self._target_mm = "", None
            self._send(GREETING)
        elif byte in (b"\x85", b"!") and self._target_mm is not None:
            self._target_mm = round(self._place_mm / STEP_MM) * STEP_MM
        elif byte == b"?" and not self._homing:
            state = "Alarm" if self._alarm else "Idle" if self._target_mm is None else "Jog"
            pins = "|Pn:X" if self._pressed else ""
            place = round(self._place_mm / STEP_MM) * STEP_MM + self._offset_mm
            self._send(f"<{state}|MPos:{place:.3f},0.000,0.000|FS:0,0{pins}>\r\n".encode())

    def _execute(self, line: str) -> None:
        words = line.replace("$J=", "").split()
        if line == "$H":
            self._alarm, self._homing, self._homed_mm = False, "seek", 0.0
        elif self._alarm:
            self._send(b"error:9\r\n")
        elif line.startswith("$J="):
            values = {word[0]: float(word[1:]) for word in words}
            self._feed_mm_s = values["F"] / 60.0
            self._target_mm = values["X"] - self._offset_mm
            self._send(b"ok\r\n")
        else:
            self._send(b"error:20\r\n")

    @property
    def _pressed(self) -> bool:
        return self._place_mm <= -PULL_OFF_MM if self.jammed is None else self.jammed

    def _move(self) -> None:
        before_s = time.monotonic()
        while self._open:
            time.sleep(TICK_S)
            now_s = time.monotonic()
            with self._lock:
                if self._homing:
                    self._home(now_s - before_s)
                elif self._target_mm is not None:
                    self._jog(self._target_mm, now_s - before_s)
            before_s = now_s

    def _home(self, time_s: float) -> None:
        if self._homing == "seek" and self._pressed:
            self._homing = "back off"
            self._place_mm = min(self._place_mm, -PULL_OFF_MM)
        elif self._homing == "seek":
            change_mm = HOMING_MM_S * time_s
            self._homed_mm += change_mm
            self._place_mm = max(-PULL_OFF_MM - 0.5, self._place_mm - change_mm)
            if self._homed_mm > MOST_HOMING_MM:
                self._homing, self._alarm = "", True
                self._send(b"ALARM:9\r\n")
        else:
            self._place_mm = min(0.0, self._place_mm + HOMING_MM_S * time_s)
            if self._place_mm == 0.0:
                self._homing = ""
                self._send(b"ok\r\n")

    def _jog(self, target_mm: float, time_s: float) -> None:
        rest_mm = abs(target_mm - self._place_mm)
        change_mm = min(rest_mm, self._feed_mm_s * time_s)
        self._place_mm += math.copysign(change_mm, target_mm - self._place_mm)
        if change_mm == rest_mm:
            self._place_mm, self._target_mm = target_mm, None
