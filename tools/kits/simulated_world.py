"""What is no software of the robot: carriage, ground and instrument, in this process.

The seconds of the instrument pass only while its driver waits, so no test depends on the speed of
the computer. A `World` outlives the robots that a test kills.
"""

from __future__ import annotations

import shutil
import threading
from collections import defaultdict, deque
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, DefaultDict, Deque, List, Optional, Type

import numpy as np

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.low.shared_state import open_shared_state
from gpr20_simulator.mid.analyzer.instrument import SimulatedVna
from gpr20_simulator.mid.analyzer.sweeper import Sweeper, SweepPace
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings
from gpr20_simulator.mid.carriage import carriage_position, start_steps
from gpr20_simulator.mid.faults import FaultBoard, FaultSwitch
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe, SweptMedium
from gpr20_simulator.mid.world.scene import X_AXIS, Y_AXIS, Z_AXIS, RobotMechanics, Scene
from gpr20_survey.trace.trace import Trace
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaError, VnaNoAnswerError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits
from gpr20_vna_acquisition.mid.exchanges import Transport

# A wait for what certainly comes ends here, so that a fault of the test ends it [s].
LIMIT_S = 60.0
EXCHANGE_S = 0.001
CONNECT = "connect"
SECONDS_PER_POINT = 350e-6
# Coarser than the robot's: each step costs the time of this computer.
STEP_MM = 0.1
MECHANICS = RobotMechanics(
    replace(X_AXIS, size_per_step=STEP_MM), replace(Y_AXIS, size_per_step=STEP_MM), Z_AXIS
)


class StepTime(Clock):
    """Time that passes in waits alone, without waiting."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        """Return the time [s]."""
        return self._now_s

    def sleep_until_s(self, deadline_s: float) -> None:
        """Let the time pass until then [s]."""
        self._now_s = max(self._now_s, deadline_s)

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        """Let the time pass unless the event is set [s]."""
        if not event.is_set():
            self.sleep_until_s(self._now_s + timeout_s)
        return event.is_set()


class InstrumentTime(StepTime):
    """Time that passes only while the driver of the instrument waits.

    The thread of the sweeps gets its turn at each moment for which it waits, and what it does then
    has ended before more time passes: every run is the same.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._now_s = self._due_s = 1000.0
        self._wake: Optional[threading.Event] = None
        self.sweeper = _SweeperClock(self)

    def sleep_until_s(self, deadline_s: float) -> None:
        """Let the time pass until then [s]."""
        with self._changed:
            while self._sweeper_waits() and self._due_s <= deadline_s:
                self._now_s = max(self._now_s, self._due_s)
                assert self._wake is not None
                self._wake.set()
            super().sleep_until_s(deadline_s)

    def _sweeper_waits(self) -> bool:
        return self._changed.wait_for(
            lambda: self._wake is not None and not self._wake.is_set(), LIMIT_S
        )

    def await_turn(self, wake: threading.Event, timeout_s: float) -> None:
        """Let the thread of the sweeps wait for a command or until a time has passed [s]."""
        with self._changed:
            self._wake, self._due_s = wake, self._now_s + timeout_s
            self._changed.notify_all()
        wake.wait()
        with self._changed:
            self._wake = None


class _SweeperClock(Clock):
    def __init__(self, time: InstrumentTime) -> None:
        self._time = time

    def now_s(self) -> float:
        return self._time.now_s()

    def wait_s(self, event: threading.Event, timeout_s: float) -> bool:
        self._time.await_turn(event, timeout_s)
        return True


class LaterProbe(PositionProbe):
    """A position probe that was on for long: its numbers of two sweeps differ by little.

    So a point that is measured again agrees with its trace.
    """

    def s21(
        self,
        frequency_hz: np.ndarray,
        position: AntennaPosition,
        sweep_number: int,
        noise_gain: float = 1.0,
    ) -> np.ndarray:
        """Return what a position probe does 5000 sweeps later."""
        return super().s21(frequency_hz, position, sweep_number + 5000, noise_gain)


class World:
    """Carriage, ground and instrument, with their faults, and the disk.

    Args:
        folder: For everything that is stored.
        medium: What the instrument measures: where it is, and the number of the sweep.
        instrument: Fields of the scene's instrument.
    """

    def __init__(
        self, folder: Path, medium: Optional[SweptMedium] = None, **instrument: Any
    ) -> None:
        self.folder, self.data = folder, folder / "data"
        self.acknowledged: List[Trace] = []
        self.free_bytes = 10**12
        self.scene = Scene(robot=MECHANICS)
        self.scene = replace(self.scene, instrument=replace(self.scene.instrument, **instrument))
        self.state = open_shared_state(folder / "state", start_steps(MECHANICS))
        self.time = InstrumentTime()
        self.vna_faults = FaultBoard(self.time.now_s)
        # The data replies of the instrument, as bytes, by their kind.
        self.sent: DefaultDict[str, List[bytes]] = defaultdict(list)
        self.sweeper = Sweeper(
            medium or LaterProbe(),
            self.position,
            self.time.sweeper,
            VnaSettings().plan(SECONDS_PER_POINT),
            SweepPace().faster(10.0),
        )
        self.instrument = SimulatedVna(
            self.sweeper,
            self.time,
            self.scene.instrument,
            self.vna_faults,
            SECONDS_PER_POINT,
            lambda kind, reply: self.sent[kind].append(reply),
        )
        self._switch = FaultSwitch(self.state, self.vna_faults)
        # Called before each message to the instrument, and with CONNECT before each new link.
        self.on_message: Callable[[str], None] = lambda _message: None
        self.sweeper.start()

    def position(self) -> AntennaPosition:
        """Return where the antennas are."""
        return carriage_position(self.state, MECHANICS)

    def fault(self, *faults: str, device: str = "vna", count: int = 0) -> None:
        """Switch faults of a device on, or with NONE all of them off."""
        for fault in faults:
            self._switch.set(device, fault, count)

    def keep_disk(self) -> None:
        """Let the next robot find the disk as it is now, whatever the present one does to its."""
        kept = self.folder / f"{self.data.name}_"
        if self.data.exists():
            shutil.copytree(str(self.data), str(kept))
        self.data = kept

    def link(self, address: str, limits: LinkLimits) -> Transport:
        """Open a link to the instrument."""
        self.on_message(CONNECT)
        return _Link(self, address, limits)

    def close(self) -> None:
        """End the thread."""
        self.sweeper.stop()


class _Link:
    """A link without a network: every message takes a little of the instrument's time."""

    def __init__(self, world: World, address: str, limits: LinkLimits) -> None:
        self._world, self._address, self._limits = world, address, limits
        self._answers: Deque[bytes] = deque()
        self._late: List[bytes] = []
        self._open = True
        self._fail(world.instrument.opened(), limits.connect_s, VnaConnectionError)

    def write(self, command: str) -> None:
        self._execute(command)

    def ask_raw(self, query: str, limit_s: Optional[float] = None) -> bytes:
        self._execute(query)
        if not self._answers:
            self._fail(NetworkFault.NO_REPLY, self._limits.answer_s if limit_s is None else limit_s)
        return self._answers.popleft()

    def clear(self) -> None:
        self._answers.clear()
        self._late.clear()

    def lock(self) -> None:
        pass

    def unlock(self) -> None:
        pass

    def local(self) -> None:
        self._world.instrument.set_remote(False)

    def close(self) -> None:
        self._open = False

    def _execute(self, message: str) -> None:
        self._world.time.sleep_until_s(self._world.time.now_s() + EXCHANGE_S)
        self._world.on_message(message)
        if not self._open:
            self._fail(NetworkFault.DROP_CONNECTIONS, 0.0)
        outcome = self._world.instrument.execute(message.encode("ascii"))
        self._answers.extend(self._late)
        self._late.clear()
        if outcome.fault is NetworkFault.ANSWER_LATE:
            self._late.append(outcome.answer)
            return
        self._fail(outcome.fault, self._limits.answer_s)
        if outcome.answer:
            self._answers.append(outcome.answer)

    def _fail(
        self, fault: NetworkFault, limit_s: float, error: Type[VnaError] = VnaNoAnswerError
    ) -> None:
        """End the link as the fault does, with what the driver sees of it."""
        if fault is NetworkFault.NONE:
            return
        self._open = False
        if fault is NetworkFault.DROP_CONNECTIONS:
            error, reason = (
                VnaConnectionError,
                Message("the connection was closed by the other side"),
            )
        else:
            self._world.time.sleep_until_s(self._world.time.now_s() + limit_s)
            reason = Message("no answer in time")
        raise error(
            Message(
                "communication with the VNA at {address} failed: {reason}; check the VNA and "
                "its network cable",
                address=self._address,
                reason=reason,
            )
        )
