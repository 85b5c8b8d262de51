"""Qt's translation source files (.ts), read as they are: nothing needs to be compiled."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, Tuple
from xml.etree import ElementTree

from gpr20_user_interface.errors import LanguageError

# Context, which is the name of a widget's class, and text in the source.
Message = Tuple[str, str]
FOLDER = Path(__file__).resolve().parent.parent / "translations"


def read_translations(path: Path) -> Dict[Message, str]:
    """Return every finished translation of a file by its context and source text.

    Raises:
        LanguageError: The file is missing or is not XML.
    """
    try:
        root = ElementTree.parse(str(path)).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise LanguageError(f"the translations {path} cannot be read: {error}") from error
    found: Dict[Message, str] = {}
    for context in root.iter("context"):
        name = context.findtext("name", "")
        for message in context.iter("message"):
            translation = message.find("translation")
            if translation is not None and translation.text and translation.get("type") is None:
                found[name, message.findtext("source", "")] = translation.text
    return found
