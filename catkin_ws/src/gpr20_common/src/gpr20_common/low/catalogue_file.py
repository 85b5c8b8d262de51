"""The gettext catalogue of every sentence that people read, read as its source (.po)."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Mapping

import polib

from gpr20_common.catalogue import Catalogue, Language
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message

FOLDER = Path(__file__).resolve().parent.parent / "translations"


@functools.lru_cache(maxsize=None)
def read_catalogue(language: Language) -> Catalogue:
    """Return the catalogue of a language; the templates themselves are the English one.

    Its file is read once: reading it takes longer than opening a window.

    Raises:
        InvalidValueError: The file is missing or is no catalogue.
    """
    if language is Language.ENGLISH:
        return Catalogue()
    return Catalogue(read_translations(FOLDER / f"{language.value}.po"))


def read_translations(path: Path) -> Mapping[str, str]:
    """Return the finished translations of a catalogue by their English templates.

    Raises:
        InvalidValueError: The file is missing or is no catalogue.
    """
    try:
        catalogue = polib.pofile(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidValueError(
            Message("the translations {path} cannot be read", path=path, details=error)
        ) from error
    return {entry.msgid: entry.msgstr for entry in catalogue.translated_entries()}
