"""A recorder in place of the module pigpio, with the calls of version 1.78 and a daemon behind it.

The daemon transmits in the time of a clock that the test moves: waves queue up as with
WAVE_MODE_ONE_SHOT_SYNC, and their edges are recorded with the moment at which each is made.
"""

from __future__ import annotations

from typing import Any, Dict, List, NamedTuple, Optional, Tuple


class Error(Exception):
    """What the library raises for every negative answer of the daemon."""


class Pulse:
    def __init__(self, gpio_on, gpio_off, delay):
        self.gpio_on = gpio_on
        self.gpio_off = gpio_off
        self.delay = delay


class Sending(NamedTuple):
    wave: int
    begin_s: float
    end_s: float
    edges: List[Tuple[float, int, int]]


class RecordedPigpio:
    """The module; `pi()` connects to the one daemon behind it."""

    INPUT, OUTPUT = 0, 1
    PUD_OFF, PUD_DOWN, PUD_UP = 0, 1, 2
    WAVE_MODE_ONE_SHOT_SYNC, NO_TX_WAVE = 2, 9999
    error = Error
    pulse = Pulse

    def __init__(self, clock: Any) -> None:
        self.clock = clock
        self.running = True
        self.connected = False
        self.modes: Dict[int, int] = {}
        self.pulls: Dict[int, int] = {}
        self.levels: Dict[int, int] = {}
        self.written_s: Dict[int, float] = {}
        self.inputs: Any = lambda gpio: 1
        self.added: List[Pulse] = []
        self.waves: Dict[int, List[Pulse]] = {}
        self.sendings: List[Sending] = []
        self.lost_after: Optional[int] = None
        # Of each GPIO: how many sendings were counted, and their edges.
        self._counted: Dict[int, Tuple[int, int]] = {}

    def pi(self, host="localhost", port=8888, show_errors=True):
        self.connected = self.running
        return RecordedPi(self)

    def rising_edges(self, gpio: int) -> List[float]:
        """When the GPIO went high [s of the clock], as far as that has happened."""
        return [at_s for sending in self.sendings for at_s in self._rising(sending, gpio)]

    def count_rising_edges(self, gpio: int) -> int:
        """Return how often the GPIO went high; what was transmitted is counted once."""
        ended, count = self._counted.get(gpio, (0, 0))
        while ended < len(self.sendings) and self.sendings[ended].end_s <= self.clock.now_s():
            count += len(self._rising(self.sendings[ended], gpio))
            ended += 1
        self._counted[gpio] = (ended, count)
        return count + sum(len(self._rising(one, gpio)) for one in self.sendings[ended:])

    def _rising(self, sending: Sending, gpio: int) -> List[float]:
        now_s = self.clock.now_s()
        return [at_s for at_s, on, _off in sending.edges if on >> gpio & 1 and at_s <= now_s]

    def level(self, gpio: int) -> int:
        """Return the level of the GPIO now: of the last edge, or of a later write."""
        now_s = self.clock.now_s()
        level, since_s = self.levels[gpio], self.written_s[gpio]
        for sending in self.sendings:
            for at_s, on, off in sending.edges:
                if since_s < at_s <= now_s and (on | off) >> gpio & 1:
                    level, since_s = on >> gpio & 1, at_s
        return level


class RecordedPi:
    def __init__(self, daemon: RecordedPigpio) -> None:
        self._daemon = daemon
        self.connected = daemon.connected

    def set_mode(self, gpio, mode):
        self._daemon.modes[gpio] = mode
        return self._answer(0)

    def set_pull_up_down(self, gpio, pud):
        self._daemon.pulls[gpio] = pud
        return self._answer(0)

    def write(self, gpio, level):
        assert level in (0, 1)
        if self._daemon.modes.get(gpio) != self._daemon.OUTPUT:
            raise Error("bad mode")
        self._daemon.levels[gpio] = level
        self._daemon.written_s[gpio] = self._daemon.clock.now_s()
        return self._answer(0)

    def read(self, gpio):
        return self._answer(self._daemon.inputs(gpio))

    def wave_clear(self):
        self._daemon.waves.clear()
        self._daemon.added.clear()
        return self._answer(0)

    def wave_add_generic(self, pulses):
        assert all(isinstance(one.delay, int) and one.delay > 0 for one in pulses)
        self._daemon.added += pulses
        return self._answer(len(self._daemon.added))

    def wave_create_and_pad(self, percent):
        assert 0 < percent <= 100
        free = (number for number in range(250) if number not in self._daemon.waves)
        if (len(self._daemon.waves) + 1) * percent > 100:
            raise Error("too many control blocks")
        wave = next(free)
        self._daemon.waves[wave], self._daemon.added = self._daemon.added, []
        return self._answer(wave)

    def wave_send_using_mode(self, wave_id, mode):
        daemon = self._daemon
        assert mode == daemon.WAVE_MODE_ONE_SHOT_SYNC
        if daemon.lost_after is not None and len(daemon.sendings) >= daemon.lost_after:
            return self._answer(10)
        begin_s = daemon.clock.now_s()
        if daemon.sendings:
            begin_s = max(begin_s, daemon.sendings[-1].end_s)
        at_s, edges = begin_s, []
        for one in daemon.waves[wave_id]:
            edges.append((at_s, one.gpio_on, one.gpio_off))
            at_s += one.delay * 1e-6
        daemon.sendings.append(Sending(wave_id, begin_s, at_s, edges))
        return self._answer(10)

    def wave_tx_at(self):
        now_s = self._daemon.clock.now_s()
        for sending in reversed(self._daemon.sendings):
            if sending.begin_s <= now_s < sending.end_s:
                return self._answer(sending.wave)
            if sending.end_s <= now_s:
                break
        return self._answer(self._daemon.NO_TX_WAVE)

    def wave_delete(self, wave_id):
        if wave_id not in self._daemon.waves:
            raise Error("non existent wave id")
        now_s = self._daemon.clock.now_s()
        sending = next(one for one in reversed(self._daemon.sendings) if one.wave == wave_id)
        assert sending.end_s <= now_s, "a wave was deleted while it was being transmitted"
        del self._daemon.waves[wave_id]
        return self._answer(0)

    def wave_tx_stop(self):
        now_s = self._daemon.clock.now_s()
        for place, sending in enumerate(self._daemon.sendings):
            if sending.end_s > now_s:
                made = [edge for edge in sending.edges if edge[0] <= now_s]
                self._daemon.sendings[place] = sending._replace(end_s=now_s, edges=made)
        return self._answer(0)

    def stop(self):
        self.connected = False

    def _answer(self, value):
        if not self._daemon.running:
            raise ConnectionResetError("the daemon is gone")
        return value
