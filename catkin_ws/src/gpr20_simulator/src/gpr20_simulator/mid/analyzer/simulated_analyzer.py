"""The simulated analyzer put together: medium, receiver, instrument and network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Callable, Optional

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_simulator.faults import SimulatorError
from gpr20_simulator.low.vxi11_server import Vxi11Server
from gpr20_simulator.mid.analyzer.instrument import Capture, SimulatedVna
from gpr20_simulator.mid.analyzer.sweeper import Sweeper, SweepPace
from gpr20_simulator.mid.analyzer.vna_settings import VnaSettings
from gpr20_simulator.mid.faults import FaultBoard
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition, PositionProbe, SweptMedium
from gpr20_simulator.mid.world.scene import InstrumentScene, Scene


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
