"""Compute the scenes of the benchmark and write them with their truth.

    python benchmarks/worlds/make_scenes.py lines --count 200 --output FILE.npz [--card]
    python benchmarks/worlds/make_scenes.py uniandes --output FILE.npz [--card]
    python benchmarks/worlds/make_scenes.py areas --count 8 --output FILE.npz [--card]
    python benchmarks/worlds/make_scenes.py born --count 40 --output FILE.npz

Each scene is a transfer function, received field over sent current, at 60 mm between the antennas,
as 16-bit parts of the largest value of the scene; of `born` what is the same at each position is
apart (`level`), and the rest is rounded, so that the file is small. With --seconds no scene is
begun later.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any, Callable, Dict, List

import area_field
import area_scenes
import born_scenes
import line_field
import line_scenes
import numpy as np
from line_field import pulse, transfer

LINE_HZ = np.linspace(600e6, 6e9, 81)
AREA_FREQUENCIES = 49
# Long enough for the deepest echo at the highest permittivity, and its reverberation.
LINE_RECORD_S = 10.5e-9
BOXES_AT_ONCE = 63
# 78 dB below the largest value: under the noise that the benchmark adds.
ROUNDED_TO = 4


def line(seed: int, on_card: bool) -> Dict[str, Any]:
    """Return the recorded line of a seed."""
    scene = line_scenes.draw(seed)
    painted = line_scenes.paint(scene)
    step_s = line_field.step_s(line_scenes.CELL_M)
    sent = pulse(2.6e9, step_s, round(LINE_RECORD_S / step_s))
    windows, materials = painted.windows, painted.materials
    echoes = line_field.received(windows, materials, line_scenes.CELL_M, sent, on_card)
    truth = {**asdict(scene), "ground": scene.ground.value}
    truth["bodies"] = [{**asdict(one), "kind": one.kind.value} for one in scene.bodies]
    return {
        **packed(transfer(echoes, sent, step_s, LINE_HZ)),
        "frequency_hz": LINE_HZ,
        "x_m": line_scenes.positions_m(),
        "height_m": painted.recorded_height_m.astype(np.float32),
        "truth": truth,
    }


def area(scene: area_scenes.AreaScene, on_card: bool) -> Dict[str, Any]:
    """Return the recorded area (y, x, frequency) of a scene."""
    boxes, materials = area_scenes.paint(scene)
    step_s = area_field.step_s(scene.cell_m)
    sent = pulse(scene.last_hz * 0.5, step_s, round(scene.record_s / step_s))
    echoes = [
        area_field.received(part, materials, scene.cell_m, sent, on_card)
        for part in boxes.parts(BOXES_AT_ONCE)
    ]
    frequency_hz = np.linspace(600e6, scene.last_hz, AREA_FREQUENCIES)
    s21 = transfer(np.concatenate(echoes), sent, step_s, frequency_hz)
    return {
        **packed(s21.reshape(scene.positions, scene.positions, -1)),
        "frequency_hz": frequency_hz,
        "x_m": scene.step_m * np.arange(scene.positions),
        "truth": asdict(scene),
    }


def born(number: int) -> Dict[str, Any]:
    """Return the recorded area (y, x, frequency) of one of the Born scenes."""
    scene = born_scenes.draw(number)
    level, of_bodies = born_scenes.echoes(scene)
    largest = float(np.abs(level + of_bodies).max())
    parts, of_level = (
        np.stack([one.real, one.imag], axis=-1) / largest * 32767 for one in (of_bodies, level)
    )
    return {
        "s21": (ROUNDED_TO * np.rint(parts / ROUNDED_TO)).astype(np.int16),
        "level": np.rint(of_level).astype(np.int16),
        "largest": largest,
        "frequency_hz": born_scenes.FREQUENCY_HZ,
        "x_m": born_scenes.STEP_M * np.arange(born_scenes.POSITIONS),
        "truth": asdict(scene),
    }


def packed(s21: np.ndarray) -> Dict[str, Any]:
    """Return spectra as 16-bit real and imaginary parts, and the value of 32767."""
    largest = float(np.abs(s21).max())
    parts = np.stack([s21.real, s21.imag], axis=-1) / largest
    return {"s21": np.rint(32767 * parts).astype(np.int16), "largest": largest}


def write(found: List[Dict[str, Any]], path: Path) -> None:
    """Write scenes: arrays with a first axis of scenes, and the truth as JSON."""
    arrays = {key: np.stack([one[key] for one in found]) for key in found[0] if key != "truth"}
    np.savez_compressed(path, truth=json.dumps([one["truth"] for one in found]), **arrays)


def main() -> None:
    """Compute the scenes until they are done or the time is over."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("lines", "uniandes", "areas", "born"))
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--card", action="store_true", help="compute on a graphics card")
    chosen = parser.parse_args()
    jobs: List[Callable[[], Dict[str, Any]]]
    if chosen.what == "lines":
        jobs = [lambda seed=seed: line(seed, chosen.card) for seed in range(chosen.count)]
    elif chosen.what == "born":
        jobs = [lambda number=number: born(number) for number in range(chosen.count)]
    else:
        random = [area_scenes.draw(seed) for seed in range(chosen.count)]
        scenes = area_scenes.uniandes() if chosen.what == "uniandes" else random
        jobs = [lambda scene=scene: area(scene, chosen.card) for scene in scenes[: chosen.count]]
    start_s = time.monotonic()
    found = []
    for job in jobs:
        if time.monotonic() - start_s >= chosen.seconds:
            break
        found.append(job())
    write(found, chosen.output)
    print(f"{chosen.what}: {len(found)} of {len(jobs)} in {time.monotonic() - start_s:.1f} s")


if __name__ == "__main__":
    main()
