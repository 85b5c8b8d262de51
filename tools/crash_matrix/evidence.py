"""What a survey's folder holds, read with tools that are not those that wrote it."""

from __future__ import annotations

import collections
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Iterable, Iterator, List, Set, Tuple

from stock_readers import bag_traces, mcap_traces, torn_mcap_traces
from storage_kit import wait_until

from gpr20_simulator.mid.world.medium import probed_position_mm, probed_rotation_deg
from gpr20_survey.files.folder_lock import writer_of

# The position probe gives the rotation to 0.4 degrees; a step of the motor is 1.8 degrees.
ROTATION_TOLERANCE_DEG = 0.9
EXPORT_BAG = (sys.executable, "-m", "gpr20_analysis.commands.main", "export", "--format", "bag")
VERIFY = Path(__file__).resolve().parents[2] / "scripts/verify.sh"
Place = Tuple[float, float, float]


def survey_id_of(folder: Path) -> str:
    """Return the id of the survey in a folder."""
    return str(_description(folder)["survey_id"])


def outcome_of(folder: Path) -> str:
    """Return how the survey in a folder ended; empty while it has not, or was cut off ending."""
    # The manifest is written last.
    if not (folder / "manifest.json").is_file():
        return ""
    return str(_description(folder).get("outcome", ""))


def faults_after_a_kill(folder: Path, acknowledged: Iterable[str]) -> List[str]:
    """Return what a copy of the files, as they lie there now, lacks.

    Args:
        folder: A survey's folder, in which a node may be writing.
        acknowledged: Sample ids that were acknowledged before the copy is made.
    """
    expected = set(acknowledged)
    faults = []
    with tempfile.TemporaryDirectory() as copies:
        for kind, name, read in (
            ("JSON files", "traces", _whole_json_files),
            ("MCAP", "survey.mcap", lambda path: set(_samples_of(torn_mcap_traces(path)))),
        ):
            copy = _copied(folder / name, Path(copies) / name)
            lacking = expected - read(copy)
            if lacking:
                faults.append(f"{folder.name}: after a kill the {kind} lack {sorted(lacking)[:3]}")
    return faults


def faults_in_the_end(folder: Path, acknowledged: Iterable[str], planned: Set[Place]) -> List[str]:
    """Return everything lost, doubled or wrong in a survey that was completed."""
    stored = [json.loads(path.read_text()) for path in sorted(folder.glob("traces/*.json"))]
    samples = [one["sample_id"] for one in stored]
    faults = [f"acknowledged and lost: {one}" for one in set(acknowledged) - set(samples)]
    if sorted(one["index"] for one in stored) != list(range(len(planned))):
        faults.append(f"{len(stored)} traces, not each of {len(planned)} once")
    places = {(one["x_coord_mm"], one["y_coord_mm"], one["z_coord_deg"]) for one in stored}
    if places != planned:
        faults.append(f"other places than planned: {sorted(places ^ planned)[:3]}")
    for one in stored:
        faults.extend(_faults_of_place(one))
    # The node may have been killed before it was made.
    make_bag = [*EXPORT_BAG, str(folder)]
    made = (folder / "survey.bag").exists
    wait_until(lambda: made() or subprocess.run(make_bag, check=False).returncode == 0)
    wait_until(lambda: writer_of(folder) is None)
    for kind, recorded in (
        ("bag", _samples_of(bag_traces(folder / "survey.bag"))),
        ("MCAP", _samples_of(mcap_traces(folder / "survey.mcap"))),
    ):
        if collections.Counter(recorded) != collections.Counter(samples):
            faults.append(f"the {kind} holds other traces than the JSON files")
    verdict = subprocess.run(
        [str(VERIFY), str(folder)], capture_output=True, text=True, check=False
    )
    if verdict.returncode != 0:
        faults.append(f"verify.sh ends with {verdict.returncode}: {verdict.stdout[-300:]}")
    return [f"{folder.name}: {fault}" for fault in faults]


def _description(folder: Path) -> dict:
    return dict(json.loads((folder / "survey.json").read_text()))


def _faults_of_place(trace: dict) -> List[str]:
    """Compare where a trace says it was measured with where the carriage truly was."""
    said = (trace["x_coord_mm"], trace["y_coord_mm"])
    said_deg = trace["z_coord_deg"]
    values = {complex(*pair) for pair in zip(trace["s21_real"], trace["s21_imag"])}
    if len(values) != 1:
        return [f"trace {trace['index']} was measured while the carriage moved"]
    value = values.pop()
    truth, truth_deg = probed_position_mm(value), probed_rotation_deg(value)
    if truth == said and abs(truth_deg - said_deg) < ROTATION_TOLERANCE_DEG:
        return []
    said_text, truth_text = f"{said} mm, {said_deg:g} deg", f"{truth} mm, {truth_deg:g} deg"
    return [f"trace {trace['index']} says {said_text}, true is {truth_text}"]


def _copied(source: Path, target: Path) -> Path:
    if source.is_dir():
        target.mkdir()
        for path in source.glob("*.json"):
            shutil.copy(path, target)
    else:
        shutil.copy(source, target)
    return target


def _whole_json_files(folder: Path) -> Set[str]:
    return {json.loads(path.read_text())["sample_id"] for path in folder.glob("*.json")}


def _samples_of(traces: Iterable[Any]) -> Iterator[str]:
    return (trace.sample_id for trace in traces)
