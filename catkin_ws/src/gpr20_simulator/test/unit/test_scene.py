from __future__ import annotations

from pathlib import Path

import numpy as np
from case_kit import each_case
from fault_kit import raises_fault

from gpr20_simulator.errors import SceneError
from gpr20_simulator.faults import WRONG_SCENE
from gpr20_simulator.mid.world.ground import Ground
from gpr20_simulator.mid.world.medium import AntennaPosition
from gpr20_simulator.mid.world.scene import Scene, read_scene

SCENES = Path(__file__).parents[2] / "scenes"
FREQUENCY_HZ = np.linspace(0.6e9, 6e9, 501)

TARGET = "targets: [{name: a, shape: sphere, x_mm: 1, y_mm: 2, depth_m: 0.1%s}]"


def scene_from(tmp_path, text):
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return read_scene(str(path))


@each_case("name", ["two_targets", "three_targets"])
def test_scenes_of_the_package_have_targets_that_stand_out_of_the_noise(name):
    scene = read_scene(str(SCENES / f"{name}.yaml"))
    assert scene.name == name
    values = Ground(scene).s21(FREQUENCY_HZ, AntennaPosition(150.0, 150.0, 0.0), 1)
    assert np.max(np.abs(values)) < 0.1
    for target in scene.targets if name == "two_targets" else ():
        over = AntennaPosition(target.x_mm, target.y_mm, 0.0)
        strongest = np.abs(np.sum(Ground(scene).echoes(over).level[2:]))
        assert strongest > 20.0 * 10.0 ** (scene.noise.level_db / 20.0)


def test_keys_left_out_keep_their_defaults(tmp_path):
    scene = scene_from(tmp_path, "robot: {x: {start: 20}}\nsoil: {loss_tangent: 0}")
    assert scene.robot.x.start == 20.0
    assert scene.robot.x.upper_stop == 653.0
    assert scene.robot.y == Scene().robot.y
    assert scene.soil.relative_permittivity == 4.0
    # A number without a point becomes a float.
    assert isinstance(scene.soil.loss_tangent, float)


@each_case(
    "text, shown",
    [
        ("soil: {permitivity: 4}", ("scene/soil/permitivity", "loss_tangent")),
        ("soil: {relative_permittivity: 0.5}", ("relative_permittivity", 0.5, 1, 81)),
        ("soil: {relative_permittivity: .nan}", ("relative_permittivity", "nan")),
        ("soil: {relative_permittivity: four}", ("'four'",)),
        ("instrument: {trailing_comma: 1}", ("instrument/trailing_comma", "bool")),
        ("targets: [{name: a, shape: sphere, x_mm: 1, y_mm: 2}]", ("depth_m",)),
        (TARGET.replace("sphere", "cube") % "", ("'cube'", "sphere, disc, line")),
        (TARGET % ", size_m: 3", ("targets[0]/size_m", 3)),
        (TARGET % "" + "\nsurface: {slope_x: 0.2}", ()),
        ("surface: {wave_amplitude_m: 0.1}\nantennas: {height_m: 0.1}", ()),
        ("robot: {x: {start: -4}}", ("robot.x.start", -4)),
        ("!!python/object/apply:os.getcwd []", ()),
    ],
)
def test_wrong_scene_says_which_key_and_what_is_allowed(tmp_path, text, shown):
    with raises_fault(WRONG_SCENE, *shown, error=SceneError):
        scene_from(tmp_path, text)
