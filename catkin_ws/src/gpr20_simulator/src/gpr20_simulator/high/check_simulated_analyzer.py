"""check_simulated_analyzer: what check_analyzer says of the simulated MS2026C."""

from __future__ import annotations

from pathlib import Path

import rospkg

from gpr20_common.low.clock import Clock
from gpr20_common.message import Message
from gpr20_simulator.mid.analyzer.simulated_analyzer import AnalyzerOptions, SimulatedAnalyzer
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Scene, read_scene
from gpr20_vna_acquisition.high.check_analyzer import check
from gpr20_vna_acquisition.low.vxi11_transport import LinkLimits, connect
from gpr20_vna_acquisition.mid.analyzer_record import passed
from gpr20_vna_acquisition.mid.conformance import Bench, Extent
from gpr20_vna_acquisition.mid.vna_parameters import VnaParameters

SCENE = "scenes/two_targets.yaml"
# The antennas are elsewhere after a person was asked to change what is measured.
PLACES = (AntennaPosition(100.0, 100.0, 0.0), AntennaPosition(300.0, 400.0, 90.0))


def main() -> int:
    """Check a simulated analyzer of its own, without a robot; nothing is stored."""
    scene = read_scene(str(Path(rospkg.RosPack().get_path("gpr20_simulator")) / SCENE))
    with CheckedSimulation(scene, AnalyzerOptions()) as simulation:
        bench = simulation.bench(Extent())
        return 0 if passed(check(bench, simulation.move)) else 1


class CheckedSimulation:
    """A simulated analyzer with antennas that stand at one of two places."""

    def __init__(self, scene: Scene, options: AnalyzerOptions) -> None:
        self._place = PLACES[0]
        self._vna = SimulatedAnalyzer(
            Ground(scene), lambda: self._place, Clock(), scene.instrument, options
        )

    def __enter__(self) -> CheckedSimulation:
        self._vna.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._vna.stop()

    def bench(self, extent: Extent) -> Bench:
        """Return what checks it."""
        port = self._vna.server.port
        return Bench(VnaParameters(), lambda address: connect(address, LinkLimits(), port), extent)

    def move(self, _text: Message) -> None:
        """Do what a person is asked for: change what is measured."""
        self._place = PLACES[1]
