"""Surveys of every ending, which are damaged or reopened, and what must be true in the end."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any, Dict, Iterable, List, NamedTuple

from annotation_examples import EXAMPLE
from log_examples import marker
from mcap.reader import make_reader
from mcap_ros1.decoder import DecoderFactory
from storage_kit import OTHER_SURVEY, Kit, bag_traces, text_message, with_bag
from trace_examples import METADATA, POINTS, SURVEY, assert_same_numbers, planned_trace, read_json

from gpr20_survey.folder.recovery import read_description
from gpr20_survey.plan.markers import markers_of
from gpr20_vna_processing.mid.processing_parameters import ProcessingParameters

TRACES = [planned_trace(index) for index in range(len(POINTS))]
STORED = {"finished": len(POINTS), "stopped": 6, "interrupted": 6, "cut off": 6}
REPORT = {"verdict": "some", "coverage": "mmmmmm---"}


class Made(NamedTuple):
    """A survey's folder, and the older files that a copy of it has kept."""

    folder: Path
    older: Path


def make(place: Path, ending: str) -> Made:
    """Make a survey with a report, an annotation and a marker, and another one after its end.

    What a kill leaves of one that was cut off is what is on the disk then.
    """
    # On a busy computer it would record the last marker before it is cut off.
    limits = ProcessingParameters(timeout_s=60.0, commit_period_s=3600.0)
    kit = Kit(place / "open", limits=limits)
    folder = kit.open(metadata_json=METADATA)
    kit.add_marker(SURVEY, marker(1))
    kit.annotate(SURVEY, EXAMPLE)
    kit.report(SURVEY, json.dumps(REPORT))
    fill(kit, TRACES[: STORED[ending] - 1])
    if ending == "interrupted":
        kit.processing.interrupt_other(OTHER_SURVEY)
        kit.processing.reopen_survey(SURVEY)
    fill(kit, TRACES[STORED[ending] - 1 : STORED[ending]])
    if ending == "interrupted":
        kit.processing.interrupt_other(OTHER_SURVEY)
    elif ending != "cut off":
        kit.processing.close_survey(SURVEY, ending)
    shutil.copytree(str(folder), str(place / "older"))
    kit.add_marker(SURVEY, marker(2))
    shutil.copytree(str(place / "open"), str(place / "data"))
    kit.processing.shut_down()
    return Made(place / "data" / folder.name, place / "older")


def fill(kit: Kit, traces: Iterable[Any]) -> None:
    """Store traces, each behind a message of another topic."""
    for trace in traces:
        kit.processing.record(text_message("/t", f"before {trace.index}"))
        kit.processing.store(trace)


def resume(folder: Path, outcome: str = "finished") -> Any:
    """Resume a survey and close it again, complete if it is to be finished."""
    kit = Kit(folder.parent)
    try:
        reopened = kit.processing.reopen_survey(folder.name)
        if outcome == "finished":
            kit.finish(TRACES, reopened.stored_indices)
        else:
            kit.processing.close_survey(SURVEY, outcome)
    finally:
        kit.processing.shut_down()
    return reopened


def noted(folder: Path) -> List[str]:
    """Return the texts of the markers that are present."""
    return [one.text for one in markers_of(read_description(folder)) if one.is_present]


def texts(*numbers: int) -> List[str]:
    return [marker(number).text for number in numbers]


def tree(folder: Path) -> Dict[str, bytes]:
    """Return the content of each file of a folder, by its name."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file()
    }


def trace_file(folder: Path, index: int) -> Path:
    return next((folder / "traces").glob(f"{index:06d}_*.json"))


def traces_in_bag(folder: Path) -> List[Any]:
    """Return the traces that a stock reader finds in the bag, which is made if it is missing."""
    if not (folder / "survey.bag").exists():
        with_bag(folder)
    return list(bag_traces(folder / "survey.bag"))


def messages_in_mcap(folder: Path, topic: str = "/trace") -> List[Any]:
    """Return the messages of a topic that a stock reader finds in the MCAP."""
    with open(folder / "survey.mcap", "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [one.decoded_message for one in reader.iter_decoded_messages(topics=[topic])]


def assert_whole(folder: Path, traces: List[Any]) -> None:
    """Compare what the stock readers find in a survey that ended with what was stored."""
    files = sorted((folder / "traces").iterdir())
    for found in (map(read_json, files), traces_in_bag(folder), messages_in_mcap(folder)):
        by_index = sorted(
            found, key=lambda one: one["index"] if isinstance(one, dict) else one.index
        )
        assert len(by_index) == len(traces)
        for trace, values in zip(traces, by_index):
            assert_same_numbers(trace, values)
