"""The receiver of the simulated analyzer: sweeps that take time and see what is there."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Callable, Optional, Tuple

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.medium import AntennaPosition, SweptMedium
from gpr20_simulator.mid.sweep_plan import SweepPace, SweepPlan

IDLE_WAIT_S = 60.0
STOP_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class _Slice:
    """Points of a sweep that are due now."""

    generation: int
    sweep_number: int
    first: int
    end: int
    frequency_hz: np.ndarray
    noise_gain: float


class Sweeper:
    """Sweeps in its own thread, once or again and again.

    Data are those of the display: points of the present sweep as far as it has got, the
    rest from before. Whoever reads in the middle of a sweep gets a mixture.

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
        self._medium = medium
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
        self._midway: Optional[Callable[[], None]] = None
        self._slowest_point_s = 0.0
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
        self._data = np.zeros(plan.points, dtype=np.complex64)
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
            return self._frequency_hz, self._data.copy()

    def configure(self, plan: SweepPlan) -> None:
        """Sweep something else from now on; a sweep in progress restarts."""
        with self._lock:
            if plan == self._plan:
                return
            if plan.points != self._plan.points:
                self._data = np.zeros(plan.points, dtype=np.complex64)
            self._plan = plan
            self._frequency_hz = plan.frequency_hz()
            self._complete = False
            self._averaged = 0
            self._paused_at_s = None
            if self._running:
                self._begin_sweep()
        self._wake.set()

    def restart_average(self) -> None:
        """Forget the sweeps averaged so far."""
        with self._lock:
            self._averaged = 0

    def trigger(
        self,
        stale: bool = False,
        slowest_point_s: float = 0.0,
        midway: Optional[Callable[[], None]] = None,
    ) -> None:
        """Run one sweep and hold again; a running series only restarts its sweep.

        If the plan waits for the average, that is as many new sweeps as are averaged.

        Args:
            stale: A fault: report the sweep as complete at once and throw its data away.
            slowest_point_s: A fault: no frequency takes less than this until the next
                trigger [s].
            midway: Called once, from the sweeper's thread, when half of the sweep is done.
        """
        with self._lock:
            self._single_shot = not (self._continuous and self._running)
            self._complete = stale
            self._slowest_point_s = slowest_point_s
            self._midway = midway
            if self._plan.waits_for_average:
                self._averaged = 0
            self._begin_sweep()
            self._discard = stale
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
        """Pause; or go on: in a series where it paused, else with one new sweep."""
        if not held and not self.is_continuous:
            self.trigger()
            return
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
                due, wait_s = self._due_slice()
            if due is None:
                self._clock.wait_s(self._wake, wait_s)
            else:
                self._measure(due)

    def _due_slice(self) -> Tuple[Optional[_Slice], float]:
        """Return the slice to measure now, or how long to wait for it [s]."""
        if not self._running:
            return None, IDLE_WAIT_S
        plan = self._plan
        end = min(self._next_point + self._points_per_slice(), plan.points)
        due_s = self._started_s + end * self._point_s()
        wait_s = due_s - self._clock.now_s()
        if wait_s > 0.0:
            return None, wait_s
        first = self._next_point
        frequency_hz = self._frequency_hz[first:end]
        due = _Slice(
            self._generation, self._sweep_number, first, end, frequency_hz, plan.noise_gain
        )
        return due, 0.0

    def _points_per_slice(self) -> int:
        point_s = self._point_s()
        return max(1, int(self._pace.slice_s / point_s)) if point_s > 0.0 else self._plan.points

    def _point_s(self) -> float:
        return max(self._plan.seconds_per_point, self._slowest_point_s)

    def _measure(self, due: _Slice) -> None:
        position = self._position_of()
        values = self._medium.s21(due.frequency_hz, position, due.sweep_number, due.noise_gain)
        midway = self._take_midway(due)
        if midway:
            # Without the lock, because it may change the plan, which restarts the sweep.
            midway()
        with self._lock:
            # Whoever changed the plan or triggered meanwhile wants nothing of this sweep.
            if due.generation != self._generation or not self._running:
                return
            if not self._discard:
                self._store(due, values)
            self._next_point = due.end
            if due.end == self._plan.points:
                self._end_sweep()

    def _take_midway(self, due: _Slice) -> Optional[Callable[[], None]]:
        with self._lock:
            if due.generation != self._generation or 2 * due.end < self._plan.points:
                return None
            midway, self._midway = self._midway, None
            return midway

    def _store(self, due: _Slice, values: np.ndarray) -> None:
        share = 1.0 / min(self._averaged + 1, self._plan.averages)
        part = self._data[due.first : due.end]
        # Without averaging the value itself: the difference would lose bits of it.
        part[:] = values if share == 1.0 else part + (values - part) * share

    def _end_sweep(self) -> None:
        self._sweeps_completed += 1
        self._averaged = min(self._averaged + 1, self._plan.averages)
        is_awaited = self._plan.waits_for_average and self._averaged < self._plan.averages
        self._complete = self._complete or not is_awaited
        if self._single_shot and not is_awaited:
            self._running = False
            return
        duration_s = self._plan.points * self._point_s()
        next_s = self._started_s + max(duration_s, self._pace.shortest_period_s)
        # A machine too slow for the pace gets fewer sweeps, not a backlog of them.
        discard = self._discard and self._single_shot
        self._begin_sweep(max(next_s, self._clock.now_s() - self._pace.slice_s))
        self._discard = discard
