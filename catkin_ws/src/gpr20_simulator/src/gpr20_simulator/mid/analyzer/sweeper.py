"""The receiver of the simulated analyzer: sweeps that take time and see what is there."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import astuple, dataclass, replace
from typing import Callable, Deque, List, Optional, Tuple

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.world.medium import AntennaPosition, SweptMedium

# The newest sweep has only begun, so the one before it is needed for the other points.
MOST_WAITING_SWEEPS = 2
IDLE_WAIT_S = 60.0
STOP_TIMEOUT_S = 5.0


@dataclass(frozen=True)
class SweepPart:
    """Neighbouring points of a sweep that are measured at one position.

    Attributes:
        sweep_number: Number of the sweep.
        first: Index of the first point.
        end: Index after the last point.
        position: Where the antennas were.
        noise_gain: Noise relative to that of the settings of power-on.
    """

    sweep_number: int
    first: int
    end: int
    position: AntennaPosition
    noise_gain: float

    def continues(self, other: SweepPart) -> bool:
        """Return whether it can be measured in one with the part before it."""
        return replace(other, first=self.first, end=self.end) == self and other.end == self.first


class TraceMemory:
    """The data of the display: each point as it was swept last.

    A late display shows a sweep only some time after its end, and until then what it showed
    before. Not safe for several threads at a time.

    Args:
        medium: What is measured.
        frequency_hz: The frequencies [Hz].
    """

    def __init__(self, medium: SweptMedium, frequency_hz: np.ndarray) -> None:
        self._medium = medium
        self._frequency_hz = frequency_hz
        self._data = np.zeros(len(frequency_hz), dtype=np.complex64)
        # Parts by sweep, to be measured when somebody looks.
        self._waiting: Deque[List[SweepPart]] = deque(maxlen=MOST_WAITING_SWEEPS)
        # What is shown instead of the data; what will be shown, and from when on [s].
        self._frozen: Optional[np.ndarray] = None
        self._coming: Deque[Tuple[float, np.ndarray]] = deque()

    def set_frequencies(self, frequency_hz: np.ndarray) -> None:
        """Hold other frequencies [Hz]; data of as many points stay, as on a display."""
        self.compute()
        self.set_late(False)
        self._frequency_hz = frequency_hz
        if len(frequency_hz) != len(self._data):
            self._data = np.zeros(len(frequency_hz), dtype=np.complex64)

    def store(self, part: SweepPart) -> None:
        """Take a part into the data, to be measured when somebody looks at it."""
        if not self._waiting or self._waiting[-1][-1].sweep_number != part.sweep_number:
            self._waiting.append([part])
            return
        parts = self._waiting[-1]
        if part.continues(parts[-1]):
            parts[-1] = replace(parts[-1], end=part.end)
        else:
            parts.append(part)

    def compute(self) -> None:
        """Measure what is waiting."""
        while self._waiting:
            for part in self._waiting.popleft():
                self._data[part.first : part.end] = self._medium.s21(
                    self._frequency_hz[part.first : part.end],
                    part.position,
                    part.sweep_number,
                    part.noise_gain,
                )

    def set_late(self, late: bool) -> None:
        """From now on show what is shown now until a sweep comes that has ended, or the data."""
        if not late:
            self._frozen = None
            self._coming.clear()
        elif self._frozen is None:
            self._frozen = self._computed()

    def end_sweep(self, shown_s: float) -> None:
        """Let a late display show from a moment on [s] what was measured until now."""
        if self._frozen is not None:
            self._coming.append((shown_s, self._computed()))

    def shown(self, now_s: float) -> np.ndarray:
        """Return a copy of the data (complex64) that are shown now."""
        while self._coming and self._coming[0][0] <= now_s:
            _shown_s, self._frozen = self._coming.popleft()
        return self._computed() if self._frozen is None else self._frozen.copy()

    def _computed(self) -> np.ndarray:
        self.compute()
        return self._data.copy()


@dataclass(frozen=True)
class SweepPlan:
    """What one sweep consists of.

    Attributes:
        start_hz: First frequency [Hz].
        stop_hz: Last frequency [Hz].
        points: Number of frequencies.
        seconds_per_point: Time that one frequency takes [s].
        noise_gain: Noise relative to that of the settings of power-on.
    """

    start_hz: float
    stop_hz: float
    points: int
    seconds_per_point: float
    noise_gain: float = 1.0

    def frequency_hz(self) -> np.ndarray:
        """Return the frequencies [Hz]."""
        return np.linspace(self.start_hz, self.stop_hz, self.points)


@dataclass(frozen=True)
class SweepPace:
    """How finely a sweep is simulated.

    Attributes:
        slice_s: Points of at most this time share one look at the antennas' position [s].
        series_s: The same in a continuous series, in which sweeps begin at most this often [s].
    """

    slice_s: float = 0.0015
    series_s: float = 0.1

    def faster(self, time_scale: float) -> SweepPace:
        """Return the pace that is as fine in real seconds by a clock so much faster."""
        return SweepPace(*(seconds * time_scale for seconds in astuple(self)))


class Sweeper:
    """Sweeps once or again and again: in its own thread, or whenever `advance` is called.

    Data are those of the display: points of the present sweep as far as it has got, the
    rest from before. Whoever reads in the middle of a sweep gets a mixture. Sweeps of a series
    are computed only when somebody reads, from where the antennas were.

    Args:
        position_of: Tells where the antennas are now.
        clock: Its seconds are those of the plan and the pace.
        plan: What to sweep at first; the sweeper begins held.
        pace: How finely.

    Attributes:
        is_complete: Whether a sweep has ended since the last trigger.
        is_running: Whether a sweep is running.
        is_continuous: Whether sweeps follow each other unless held.
        sweep_number: Number of the sweep begun last.
        sweeps_completed: Number of sweeps that have come to their end.
    """

    def __init__(
        self,
        medium: SweptMedium,
        position_of: Callable[[], AntennaPosition],
        clock: Clock,
        plan: SweepPlan,
        pace: SweepPace,
    ) -> None:
        self.is_complete = self.is_running = self.is_continuous = False
        self.sweep_number = self.sweeps_completed = 0
        self._position_of = position_of
        self._clock = clock
        self._pace = pace
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._is_stopping = False
        self._is_single = True
        self._is_discarded = False
        self._slowest_point_s = self._shown_late_s = 0.0
        self._midway: Optional[Callable[[], object]] = None
        self._next_point = 0
        self._started_s = 0.0
        self._plan = plan
        self._frequency_hz = plan.frequency_hz()
        self._memory = TraceMemory(medium, self._frequency_hz)
        self._thread = threading.Thread(target=self._run, name="sweeper", daemon=True)

    def start(self) -> None:
        """Begin to work."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        with self._lock:
            self._is_stopping = True
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join(STOP_TIMEOUT_S)

    @property
    def runs_continuously(self) -> bool:
        """Whether sweeps follow each other now."""
        return self.is_continuous and self.is_running

    def snapshot(self) -> Tuple[np.ndarray, np.ndarray]:
        """Return the frequencies [Hz] and the data (complex64) as they are now."""
        with self._lock:
            return self._frequency_hz, self._memory.shown(self._clock.now_s())

    def configure(self, plan: SweepPlan) -> None:
        """Sweep something else from now on; a sweep in progress restarts."""
        with self._lock:
            if plan == self._plan:
                return
            self._plan = plan
            self._frequency_hz = plan.frequency_hz()
            self._memory.set_frequencies(self._frequency_hz)
            self.is_complete = False
            if self.is_running:
                self._begin_sweep()
        self._wake.set()

    def trigger(
        self,
        stale: bool = False,
        slowest_point_s: float = 0.0,
        shown_late_s: float = 0.0,
        midway: Optional[Callable[[], object]] = None,
    ) -> None:
        """Run one sweep and hold again; a running series only restarts its sweep.

        Args:
            stale: It is reported as complete at once, and its data are thrown away.
            slowest_point_s: No frequency takes less than this until the next trigger [s].
            shown_late_s: The display shows it so much later than its end [s]; until then, what it
                showed before.
            midway: Called once, from the sweeper's thread, when half of the sweep is done.
        """
        with self._lock:
            self._memory.compute()
            self._is_single = not self.runs_continuously
            self.is_complete = stale
            self._slowest_point_s, self._shown_late_s = slowest_point_s, shown_late_s
            self._midway = midway
            self._begin_sweep()
            self._is_discarded = stale
            self._memory.set_late(shown_late_s > 0.0)
        self._wake.set()

    def set_continuous(self, continuous: bool) -> None:
        """Sweep again and again from now on, or hold and leave the next sweep to a trigger."""
        with self._lock:
            self.is_continuous = continuous
            if not continuous:
                self.is_running = False
            else:
                self._is_single = False
                if not self.is_running:
                    self._begin_sweep()
        self._wake.set()

    def _begin_sweep(self, started_s: Optional[float] = None) -> None:
        self.sweep_number += 1
        self._next_point = 0
        self._is_discarded = False
        self.is_running = True
        self._started_s = self._clock.now_s() if started_s is None else started_s

    def advance(self) -> float:
        """Do what is due, and return how long nothing more is [s]."""
        while True:
            with self._lock:
                wait_s, midway = self._work()
            if midway is not None:
                # Without the lock: it changes the plan, which restarts the sweep.
                midway()
            elif wait_s > 0.0:
                return wait_s

    def _run(self) -> None:
        while not self._is_stopping:
            self._wake.clear()
            wait_s = self.advance()
            self._clock.wait_s(self._wake, wait_s)

    def _work(self) -> Tuple[float, Optional[Callable[[], object]]]:
        """Measure what is due; return how long to wait then [s], and what to call then."""
        if not self.is_running or self._is_stopping:
            return IDLE_WAIT_S, None
        end = min(self._next_point + self._points_per_look(), self._plan.points)
        wait_s = self._started_s + end * self._point_s() - self._clock.now_s()
        if wait_s > 0.0:
            return wait_s, None
        midway = self._midway
        if midway is not None and 2 * end >= self._plan.points:
            self._midway = None
            return 0.0, midway
        self._measure(end)
        return 0.0, None

    def _points_per_look(self) -> int:
        point_s = self._point_s()
        return max(1, int(self._look_s() / point_s)) if point_s > 0.0 else self._plan.points

    def _point_s(self) -> float:
        return max(self._plan.seconds_per_point, self._slowest_point_s)

    def _look_s(self) -> float:
        """Return how long the antennas are taken to stay where they are [s]."""
        return self._pace.slice_s if self._is_single else self._pace.series_s

    def _measure(self, end: int) -> None:
        if not self._is_discarded:
            self._memory.store(
                SweepPart(
                    self.sweep_number,
                    self._next_point,
                    end,
                    self._position_of(),
                    self._plan.noise_gain,
                )
            )
            if self._is_single:
                # While the sweep takes its time, not when somebody waits for the data.
                self._memory.compute()
        self._next_point = end
        if end == self._plan.points:
            self._end_sweep()

    def _end_sweep(self) -> None:
        self.sweeps_completed += 1
        self._memory.end_sweep(self._clock.now_s() + self._shown_late_s)
        self.is_complete = True
        if self._is_single:
            self.is_running = False
            return
        duration_s = max(self._plan.points * self._point_s(), self._pace.series_s)
        # A machine too slow for the pace gets fewer sweeps, not a backlog of them.
        latest_s = self._clock.now_s() - self._look_s()
        self._begin_sweep(max(self._started_s + duration_s, latest_s))
