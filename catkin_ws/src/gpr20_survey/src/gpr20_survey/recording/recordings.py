"""The two recordings of every survey."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.recording.bag_writer import BagFile
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.recording import Recording
from gpr20_survey.trace import utc_time


def open_recordings(folder: Path, description: Dict[str, Any]) -> List[Recording]:
    """Begin the bag and the MCAP file of a survey.

    Raises:
        OSError: The disk refused.
    """
    bag = BagFile(folder / survey_folder.BAG_FILE)
    try:
        return [bag, new_mcap(folder / survey_folder.MCAP_FILE, description)]
    except OSError:
        bag.abandon()
        raise


def new_mcap(path: Path, description: Dict[str, Any]) -> McapFile:
    """Begin the MCAP file of a survey; it holds the survey's description as it is now.

    Raises:
        SurveyRefusedError: The description does not hold when the survey started.
        OSError: The disk refused.
    """
    return McapFile(
        path,
        survey_metadata.as_texts(description),
        survey_metadata.encode(description),
        survey_metadata.started_us(description) * utc_time.NS_PER_US,
    )
