"""The simulated analyzer put together: medium, receiver, instrument and network.

Without a network its links are transports of the driver; then its seconds pass only while its
driver waits, so nothing depends on the speed of the computer.
"""

from __future__ import annotations

import threading
from collections import defaultdict, deque
from dataclasses import dataclass
from typing import Callable, DefaultDict, Deque, List, Optional, Type

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_simulator.low.message_device import NetworkFault
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_simulator.mid.analyzer.instrument import Capture, SimulatedVna
from gpr20_simulator.mid.analyzer.sweeper import Sweeper, SweepPace
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings
from gpr20_simulator.mid.faults import FaultBoard, SimulatorError
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe, SweptMedium
from gpr20_simulator.mid.world.scene import InstrumentScene, Scene
from gpr20_vna_acquisition.errors import VnaConnectionError, VnaError, VnaNoAnswerError
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits
from gpr20_vna_acquisition.mid.exchanges import Transport

SECONDS_PER_POINT = 350e-6
# What each message takes [s].
EXCHANGE_S = 0.001
# What links do besides messages, as `on_message` sees it.
CONNECT, CLOSE, LOCK, CLEAR, LOCAL = "<connect>", "<close>", "<lock>", "<clear>", "<local>"


def medium_by_name(name: str, scene: Scene) -> SweptMedium:
    """Return the medium called `scene` or `position_probe`.

    Raises:
        SimulatorError: There is no medium of that name.
    """
    if name == "scene":
        return Ground(scene)
    if name == "position_probe":
        return PositionProbe()
    raise SimulatorError(
        Message("unknown medium '{name}'; use scene or position_probe", name=name[:40])
    )


@dataclass(frozen=True)
class AnalyzerOptions:
    """How the simulated analyzer runs.

    Attributes:
        seconds_per_point: Time of one frequency of a sweep [s].
        time_scale: How much faster than real the clock goes that it is given.
        port: Port of the core channel; 0: any free one.
        portmapper_port: Port of an own portmapper; None: there is none.
    """

    seconds_per_point: float = 350e-6
    time_scale: float = 1.0
    port: int = 0
    portmapper_port: Optional[int] = None


class SimulatedAnalyzer:
    """A simulated analyzer on the network of this machine.

    Args:
        position_of: Tells where the antennas are now.
        clock: Runs `time_scale` times as fast as the real one.
        capture: Gets the kind and the exact bytes of each data reply.

    Raises:
        ListenError: A port is taken or not allowed.
    """

    def __init__(
        self,
        medium: SweptMedium,
        position_of: Callable[[], AntennaPosition],
        clock: Clock,
        description: InstrumentScene,
        options: AnalyzerOptions,
        capture: Capture = lambda _kind, _reply: None,
    ) -> None:
        self.faults = FaultBoard()
        plan = VnaSettings().plan(options.seconds_per_point)
        pace = SweepPace().faster(options.time_scale)
        self.sweeper = Sweeper(medium, position_of, clock, plan, pace)
        self.instrument = SimulatedVna(
            self.sweeper, clock, description, self.faults, options.seconds_per_point, capture
        )
        self.server = Vxi11Server(
            self.instrument, port=options.port, portmapper_port=options.portmapper_port
        )
        self.faults.on_link_gone = self.server.drop_connections

    def start(self) -> None:
        """Switch it on."""
        self.sweeper.start()
        self.server.start()

    def stop(self) -> None:
        """Switch it off."""
        self.server.stop()
        self.sweeper.stop()


class StepTime(Clock):
    """Time that passes in waits alone, without waiting."""

    def __init__(self, now_s: float = 0.0) -> None:
        self._now_s = now_s

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
    """Step time in which an instrument sweeps: each moment comes at which it has something to do.

    Attributes:
        sweeper: What sweeps.
    """

    sweeper: Sweeper

    def __init__(self) -> None:
        super().__init__(1000.0)
        self._passing = threading.Lock()

    def sleep_until_s(self, deadline_s: float) -> None:
        """Let the time pass until then [s]."""
        with self._passing:
            while True:
                due_s = self._now_s + self.sweeper.advance()
                if due_s > deadline_s:
                    break
                self._now_s = due_s
            super().sleep_until_s(deadline_s)


class InProcessAnalyzer:
    """The instrument, and its links.

    Attributes:
        time: Passes only in waits, and a little with each message.
        faults: What is wrong with it.
        sent: Its data replies, as bytes, by their kind.
        on_message: Called before each message, and with what else links do; may raise what the
            driver is to meet.
        on_answer: Returns what the driver reads instead of the answer to a query; if that is
            empty, there is no answer.
    """

    def __init__(
        self,
        medium: SweptMedium,
        position_of: Callable[[], AntennaPosition],
        description: InstrumentScene,
        pace: SweepPace,
    ) -> None:
        self.time = InstrumentTime()
        self.faults = FaultBoard(self.time.now_s)
        self.sent: DefaultDict[str, List[bytes]] = defaultdict(list)
        self.on_message: Callable[[str], None] = lambda _message: None
        self.on_answer: Callable[[str, bytes], bytes] = lambda _query, answer: answer
        plan = VnaSettings().plan(SECONDS_PER_POINT)
        self.sweeper = self.time.sweeper = Sweeper(medium, position_of, self.time, plan, pace)
        self.instrument = SimulatedVna(
            self.sweeper,
            self.time,
            description,
            self.faults,
            SECONDS_PER_POINT,
            lambda kind, reply: self.sent[kind].append(reply),
        )

    def connect(self, address: str, limits: LinkLimits) -> Transport:
        """Open a link."""
        self.on_message(CONNECT)
        return _Link(self, address, limits)


class _Link:
    """Implements `Transport`: dead after a failure, as the real one is."""

    def __init__(self, vna: InProcessAnalyzer, address: str, limits: LinkLimits) -> None:
        self._vna, self._address, self._limits = vna, address, limits
        self._answers: Deque[bytes] = deque()
        self._late: List[bytes] = []
        self._open = True
        self._fail(vna.instrument.opened(), limits.connect_s, VnaConnectionError)

    def write(self, command: str) -> None:
        self._begin(command)
        self._execute(command)

    def ask_raw(self, query: str, limit_s: Optional[float] = None) -> bytes:
        self._begin(query)
        self._execute(query)
        answer = self._answers.popleft() if self._answers else b""
        answer = self._vna.on_answer(query, answer)
        if not answer:
            self._fail(NetworkFault.NO_REPLY, self._limits.answer_s if limit_s is None else limit_s)
        return answer

    def clear(self) -> None:
        self._begin(CLEAR)
        self._answers.clear()
        self._late.clear()

    def lock(self) -> None:
        self._begin(LOCK)

    def local(self) -> None:
        self._begin(LOCAL)
        self._vna.instrument.set_remote(False)

    def close(self) -> None:
        if self._open:
            self._open = False
            self._vna.on_message(CLOSE)

    def _begin(self, message: str) -> None:
        if not self._open:
            self._fail(NetworkFault.DROP_CONNECTIONS, 0.0)
        time = self._vna.time
        time.sleep_until_s(time.now_s() + EXCHANGE_S)
        try:
            self._vna.on_message(message)
        except VnaError:
            self.close()
            raise

    def _execute(self, message: str) -> None:
        outcome = self._vna.instrument.execute(message.encode("ascii"))
        self._answers.extend(self._late)
        self._late = [outcome.answer] if outcome.fault is NetworkFault.ANSWER_LATE else []
        if not self._late:
            self._fail(outcome.fault, self._limits.answer_s)
            self._answers.extend([outcome.answer] if outcome.answer else [])

    def _fail(
        self, fault: NetworkFault, limit_s: float, error: Type[VnaError] = VnaNoAnswerError
    ) -> None:
        """End the link as the fault does, with what the driver sees of it."""
        if fault is NetworkFault.NONE:
            return
        self.close()
        reason = Message("no answer in time")
        if fault is NetworkFault.DROP_CONNECTIONS:
            error = VnaConnectionError
            reason = Message("the connection was closed by the other side")
        else:
            self._vna.time.sleep_until_s(self._vna.time.now_s() + limit_s)
        raise error(
            Message(
                "communication with the VNA at {address} failed: {reason}; check the VNA and "
                "its network cable",
                address=self._address,
                reason=reason,
            )
        )
