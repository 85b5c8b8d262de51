"""The copies of a survey's description that its recordings hold since the start."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, Dict, Optional

from gpr20_survey.errors import SurveyRefusedError
from gpr20_survey.folder import survey_folder, survey_metadata
from gpr20_survey.folder.description_differences import constant_entries
from gpr20_survey.recording.bag_reader import StoredBag
from gpr20_survey.recording.mcap_reader import read_attachment, read_metadata
from gpr20_survey.recording.survey_topics import is_metadata_topic


def sealed_description(folder: Path) -> Optional[Dict[str, Any]]:
    """Return the attachment of survey.mcap, which has a checksum.

    It is survey.json as it was when the survey began; what was written later, such as how the
    survey ended, is not in it.

    Returns:
        None if there is no whole copy, or if a folder or the like is where survey.json would be.
    """
    path = folder / survey_folder.SURVEY_FILE
    if path.exists() and not path.is_file():
        return None
    try:
        copy = read_attachment(folder / survey_folder.MCAP_FILE, survey_folder.SURVEY_FILE)
        return None if copy is None else _parsed(copy, path)
    except (OSError, UnicodeDecodeError, SurveyRefusedError):
        return None


def latched_description(folder: Path) -> Optional[Dict[str, Any]]:
    """Return the first message of the topic survey_metadata in survey.bag; it has no checksum."""
    path = folder / survey_folder.BAG_FILE
    try:
        for message in StoredBag(path).messages():
            if is_metadata_topic(message.topic):
                (size,) = struct.unpack_from("<I", message.data)
                return _parsed(message.data[4 : 4 + size], path)
    except (OSError, UnicodeDecodeError, SurveyRefusedError, struct.error):
        return None
    return None


def recorded_texts(folder: Path) -> Optional[Dict[str, str]]:
    """Return the metadata record of survey.mcap: the entries as texts, without a checksum."""
    try:
        return read_metadata(folder / survey_folder.MCAP_FILE)
    except OSError:
        return None


def agrees(description: Dict[str, Any], texts: Optional[Dict[str, str]]) -> bool:
    """Return whether a description has the constant entries of a metadata record."""
    if texts is None:
        return False
    own = survey_metadata.as_texts(constant_entries(description))
    return own == constant_entries(texts)


def _parsed(content: bytes, path: Path) -> Dict[str, Any]:
    text = content.decode("ascii")
    values = survey_metadata.parse_object(text, path.name, survey_metadata.MAX_FILE_BYTES)
    survey_metadata.check_format(values, path)
    return values
