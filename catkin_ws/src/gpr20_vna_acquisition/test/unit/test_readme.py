"""The example of the README works, with the simulated instrument."""

from __future__ import annotations

import doctest
from pathlib import Path

from gpr20_common.low.clock import Clock
from gpr20_simulator.mid.analyzer.simulated_analyzer import (
    AnalyzerOptions,
    SimulatedAnalyzer,
    medium_by_name,
)
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Scene

README = Path(__file__).resolve().parents[2] / "README.md"


def test_the_example_of_the_readme_gives_what_it_shows():
    scene = Scene()
    place = AntennaPosition(100.0, 100.0, 0.0)
    medium = medium_by_name("scene", scene)
    vna = SimulatedAnalyzer(medium, lambda: place, Clock(), scene.instrument, AnalyzerOptions())
    vna.start()
    try:
        results = doctest.testfile(
            str(README), module_relative=False, globs={"port": vna.server.port}
        )
    finally:
        vna.stop()
    assert results.attempted > 10 and results.failed == 0
