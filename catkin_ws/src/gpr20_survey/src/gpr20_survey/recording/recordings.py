"""The two recordings of every survey."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.mcap_reader import StoredMcap
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recording import Recording
from gpr20_survey.recording.stored_recording import StoredRecording


def open_recordings(folder: Path, description: Dict[str, Any], started_ns: int) -> List[Recording]:
    """Begin the bag and the MCAP file of a survey.

    Raises:
        OSError: The disk refused.
    """
    bag = BagFile(folder / survey_folder.BAG_FILE)
    try:
        mcap = _new_mcap(folder / survey_folder.MCAP_FILE, description, started_ns)
    except OSError:
        bag.abandon()
        raise
    return [bag, mcap]


def stored_recordings(
    folder: Path, description: Dict[str, Any], started_ns: int
) -> List[StoredRecording]:
    """Return the bag and the MCAP file of a survey as they are on the disk."""
    return [
        StoredBag(folder / survey_folder.BAG_FILE),
        StoredMcap(
            folder / survey_folder.MCAP_FILE,
            lambda path: _new_mcap(path, description, started_ns),
        ),
    ]


def _new_mcap(path: Path, description: Dict[str, Any], started_ns: int) -> McapFile:
    # The survey as it was at its start: how it ended is in survey.json.
    texts = survey_metadata.as_texts(description)
    return McapFile(path, texts, survey_metadata.encode(description), started_ns)
