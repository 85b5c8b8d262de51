"""The receiver of the simulated analyzer: sweeps that take time and see what is there."""

from __future__ import annotations

import threading
from typing import Callable, Optional, Tuple

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.attention import Attention
from gpr20_simulator.mid.analyzer.sweep_plan import NO_FAULTS, SweepFaults, SweepPace, SweepPlan
from gpr20_simulator.mid.analyzer.trace_memory import LateDisplay, SweepPart, TraceMemory
from gpr20_simulator.mid.world.medium import AntennaPosition, SweptMedium

IDLE_WAIT_S = 60.0
STOP_TIMEOUT_S = 5.0


class Sweeper:
    """Sweeps in its own thread, once or again and again.

    Data are those of the display: points of the present sweep as far as it has got, the
    rest from before. Whoever reads in the middle of a sweep gets a mixture. Sweeps of a series
    are computed only when somebody reads, from where the antennas were.

    Args:
        medium: What is measured.
        position_of: Tells where the antennas are now.
        clock: Its seconds are those of the plan and the pace.
        plan: What to sweep at first; the sweeper begins held.
        pace: How finely.
    """

    def __init__(
        self,
        medium: SweptMedium,
        position_of: Callable[[], AntennaPosition],
        clock: Clock,
        plan: SweepPlan,
        pace: SweepPace,
    ) -> None:
        self._position_of = position_of
        self._clock = clock
        self._pace = pace
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._stopping = False
        self._continuous = False
        self._running = False
        self._single_shot = True
        self._discard = False
        self._midway: Optional[Callable[[], object]] = None
        self._faults = NO_FAULTS
        self._complete = False
        self._averaged = 0
        self._generation = 0
        self._sweep_number = 0
        self._sweeps_completed = 0
        self._next_point = 0
        self._started_s = 0.0
        self._paused_at_s: Optional[float] = None
        self._plan = plan
        self._frequency_hz = plan.frequency_hz()
        self._memory = TraceMemory(medium, self._frequency_hz)
        self._late_display = LateDisplay(self._memory)
        self._attention = Attention(clock, pace)
        self._thread = threading.Thread(target=self._run, name="sweeper", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        with self._lock:
            self._stopping = True
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(STOP_TIMEOUT_S)

    @property
    def is_complete(self) -> bool:
        """Whether a sweep has ended since the last trigger."""
        with self._lock:
            return self._complete

    @property
    def is_running(self) -> bool:
        """Whether a sweep is running."""
        with self._lock:
            return self._running

    @property
    def is_continuous(self) -> bool:
        """Whether sweeps follow each other unless held."""
        with self._lock:
            return self._continuous

    @property
    def sweep_number(self) -> int:
        """Number of the sweep begun last."""
        with self._lock:
            return self._sweep_number

    @property
    def sweeps_completed(self) -> int:
        """Number of sweeps that have come to their end."""
        with self._lock:
            return self._sweeps_completed

    @property
    def averaged(self) -> int:
        """Number of sweeps in the present average."""
        with self._lock:
            return self._averaged

    def snapshot(self) -> Tuple[np.ndarray, np.ndarray]:
        """Return the frequencies [Hz] and the data (complex64) as they are now."""
        with self._lock:
            if not self._is_read():
                self._wake.set()
            self._attention.note_read()
            return self._frequency_hz, self._late_display.shown(self._clock.now_s())

    def configure(self, plan: SweepPlan) -> None:
        """Sweep something else from now on; a sweep in progress restarts."""
        with self._lock:
            if plan == self._plan:
                return
            self._plan = plan
            self._frequency_hz = plan.frequency_hz()
            self._memory.set_frequencies(self._frequency_hz)
            self._late_display.clear()
            self._complete = False
            self._averaged = 0
            self._paused_at_s = None
            if self._running:
                self._begin_sweep()
        self._wake.set()

    def restart_average(self) -> None:
        """Forget the sweeps averaged so far."""
        with self._lock:
            self._memory.compute()
            self._averaged = 0

    def trigger(self, faults: SweepFaults = NO_FAULTS) -> None:
        """Run one sweep and hold again; a running series only restarts its sweep.

        If the plan waits for the average, that is as many new sweeps as are averaged.
        """
        with self._lock:
            self._memory.compute()
            self._single_shot = not (self._continuous and self._running)
            self._complete = faults.stale
            self._faults = faults
            self._midway = faults.midway
            if self._plan.waits_for_average:
                self._averaged = 0
            self._begin_sweep()
            self._discard = faults.stale
            self._late_display.set_late(faults.shown_late_s > 0.0)
        self._wake.set()

    def set_continuous(self, continuous: bool) -> None:
        """Sweep again and again from now on, or hold and leave the next sweep to a trigger."""
        with self._lock:
            self._continuous = continuous
            if continuous:
                self._resume()
            else:
                self._pause()
        self._wake.set()

    def hold(self, held: bool) -> None:
        """Pause, or continue a series where it paused."""
        with self._lock:
            if held:
                self._pause()
            else:
                self._resume()
        self._wake.set()

    def _pause(self) -> None:
        if self._running:
            self._running = False
            self._paused_at_s = self._clock.now_s()

    def _resume(self) -> None:
        self._single_shot = False
        if self._running:
            return
        if self._paused_at_s is None:
            self._begin_sweep()
        else:
            self._started_s += self._clock.now_s() - self._paused_at_s
            self._paused_at_s = None
            self._running = True

    def _begin_sweep(self, started_s: Optional[float] = None) -> None:
        self._generation += 1
        self._sweep_number += 1
        self._next_point = 0
        self._discard = False
        self._paused_at_s = None
        self._running = True
        self._started_s = self._clock.now_s() if started_s is None else started_s

    def _run(self) -> None:
        while True:
            with self._lock:
                if self._stopping:
                    return
                self._wake.clear()
                generation, (end, wait_s) = self._generation, self._due_end()
            if end is None:
                self._clock.wait_s(self._wake, wait_s)
            else:
                self._measure(generation, end)

    def _due_end(self) -> Tuple[Optional[int], float]:
        """Return up to which point to measure now, or how long to wait [s]."""
        if not self._running:
            return None, IDLE_WAIT_S
        end = min(self._next_point + self._points_per_look(), self._plan.points)
        wait_s = self._started_s + end * self._point_s() - self._clock.now_s()
        return (None, wait_s) if wait_s > 0.0 else (end, 0.0)

    def _points_per_look(self) -> int:
        point_s = self._point_s()
        return max(1, int(self._look_s() / point_s)) if point_s > 0.0 else self._plan.points

    def _point_s(self) -> float:
        return max(self._plan.seconds_per_point, self._faults.slowest_point_s)

    def _look_s(self) -> float:
        """Return how long the antennas are taken to stay where they are [s]."""
        return self._pace.slice_s if self._is_watched() else self._pace.rest_s

    def _is_watched(self) -> bool:
        return self._single_shot or self._attention.is_needed

    def _is_read(self) -> bool:
        return self._single_shot or self._attention.is_read

    def _measure(self, generation: int, end: int) -> None:
        position = self._position_of()
        with self._lock:
            if generation != self._generation or not self._running:
                return
            self._attention.note_position(position)
            is_read, first, number = self._is_read(), self._next_point, self._sweep_number
            part = SweepPart(number, first, end, position, self._plan.noise_gain)
            midway = self._take_midway(end)
            if is_read:
                self._memory.compute()
        # Without the lock: the physics take their time, and whoever changes the plan midway
        # restarts the sweep.
        values = self._memory.measured(part) if is_read else None
        if midway:
            midway()
        with self._lock:
            # Whoever changed the plan or triggered meanwhile wants nothing of this sweep.
            if generation == self._generation and self._running:
                self._store(part, values)

    def _take_midway(self, end: int) -> Optional[Callable[[], object]]:
        if 2 * end < self._plan.points:
            return None
        midway, self._midway = self._midway, None
        return midway

    def _store(self, part: SweepPart, values: Optional[np.ndarray]) -> None:
        share = 1.0 / min(self._averaged + 1, self._plan.averages)
        if not self._discard:
            self._memory.store(part, values, share)
        self._next_point = part.end
        if part.end == self._plan.points:
            self._end_sweep()

    def _end_sweep(self) -> None:
        self._sweeps_completed += 1
        self._averaged = min(self._averaged + 1, self._plan.averages)
        is_awaited = self._plan.waits_for_average and self._averaged < self._plan.averages
        self._complete = self._complete or not is_awaited
        self._late_display.measured(self._clock.now_s() + self._faults.shown_late_s)
        if self._single_shot and not is_awaited:
            self._running = False
            return
        is_discarded = self._discard and self._single_shot
        self._begin_sweep(self._next_start_s())
        self._discard = is_discarded

    def _next_start_s(self) -> float:
        duration_s = self._plan.points * self._point_s()
        shortest_s = self._pace.shortest_period_s if self._is_watched() else self._pace.rest_s
        next_s = self._started_s + max(duration_s, shortest_s)
        # A machine too slow for the pace gets fewer sweeps, not a backlog of them.
        return max(next_s, self._clock.now_s() - self._look_s())
