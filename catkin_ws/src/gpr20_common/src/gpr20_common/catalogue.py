"""Messages in the language of those who read them.

The gettext catalogues (.po) of the project are in the folder of this package. Those in the folder
that the environment variable GPR20_TRANSLATIONS names, by default ~/.gpr20/translations, add
languages and other words to one that exists.
"""

from __future__ import annotations

import functools
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Dict, List, Mapping, Optional, Tuple

import polib

from gpr20_common import faults
from gpr20_common.errors import ConfigurationError, InvalidValueError
from gpr20_common.message import Message

FOLDER = Path(__file__).resolve().parent / "translations"
VARIABLE = "GPR20_TRANSLATIONS"
_CODE = re.compile("[a-z]{2,3}(_[A-Z]{2})?")
# In the header; reading all of a catalogue takes longer than opening a window.
_NAME = re.compile(r'^"X-Language-Name: *([^"\\]{1,40}?) *\\n"', re.MULTILINE)


@dataclass(frozen=True)
class Language:
    """A language: its ISO 639-1 code, as es or pt_BR, and what its speakers call it."""

    ENGLISH: ClassVar[Language]
    SPANISH: ClassVar[Language]

    value: str
    own_name: str

    def __str__(self) -> str:
        return self.value


# The language of the templates, and the one that the project itself translates all of them into.
Language.ENGLISH = Language("en", "English")
Language.SPANISH = Language("es", "Español")


class Catalogue:
    """Translates templates, and messages with the values in them; English without translations."""

    def __init__(self, translations: Optional[Mapping[str, str]] = None) -> None:
        self._translations = translations or {}

    def template(self, template: str) -> str:
        return self._translations.get(template) or template

    def text(self, message: Message) -> str:
        """Return the sentence of a message, without its details.

        It is English if a translation has other fields than its template.
        """
        try:
            return message.sentence(self.template)
        except (LookupError, ValueError):
            return message.sentence()

    def tr(self, template: str, /, **values: object) -> str:
        """Return the text of a template that is written where it is shown."""
        return self.text(Message(template, **values))


def catalogue_folders() -> Tuple[Path, ...]:
    """Return the folders of catalogues; a translation of the last one counts."""
    own = os.environ.get(VARIABLE) or "~/.gpr20/translations"
    return FOLDER, Path(own).expanduser()


def languages() -> List[Language]:
    """Return English and every language that has a catalogue, by their codes."""
    found = {Language.ENGLISH.value: Language.ENGLISH}
    for path in (path for folder in catalogue_folders() for path in folder.glob("*.po")):
        if path.is_file() and _CODE.fullmatch(path.stem) and path.stem not in found:
            with path.open(encoding="utf-8", errors="replace") as file:
                name = _NAME.search(file.read(4000))
            found[path.stem] = Language(path.stem, name.group(1) if name else path.stem)
    return [found[code] for code in sorted(found)]


def language_from_code(code: object) -> Language:
    """Return the language with a code; an InvalidValueError names those that have a catalogue."""
    for language in languages():
        if language.value == code:
            return language
    allowed = ", ".join(f"{one.value} ({one.own_name})" for one in languages())
    raise ConfigurationError(
        Message("language is {code}; it must be one of {allowed}", code=repr(code), allowed=allowed)
    )


def language_from_environment(environment: Mapping[str, str]) -> Language:
    """Return the language that a terminal asks for; English if it has no catalogue."""
    # As gettext: LANGUAGE lists several, and does not count where the locale is C.
    names = ("LC_ALL", "LC_MESSAGES", "LANG")
    locale = next((environment[name] for name in names if environment.get(name)), "")
    listed = "" if locale in ("C", "POSIX") else environment.get("LANGUAGE", "")
    known = {one.value: one for one in languages()}
    codes = [one.split(".")[0] for one in (listed or locale).split(":")]
    found = (known.get(one) or known.get(one.split("_")[0]) for one in codes)
    return next((one for one in found if one is not None), Language.ENGLISH)


def read_catalogue(language: Language) -> Catalogue:
    """Return the catalogue of a language; raises as `read_translations`."""
    if language == Language.ENGLISH:
        return Catalogue()
    paths = [folder / f"{language.value}.po" for folder in catalogue_folders()]
    translations: Dict[str, str] = {}
    # Without any, the first is named.
    for path in [path for path in paths if path.exists()] or paths[:1]:
        translations.update(read_translations(path))
    return Catalogue(translations)


@functools.lru_cache(maxsize=None)
def read_translations(path: Path) -> Mapping[str, str]:
    """Return the finished translations of a catalogue, or raise an InvalidValueError."""
    try:
        catalogue = polib.pofile(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InvalidValueError(
            Message("the translations {path} cannot be read", path=path, details=error),
            fault=faults.FILE_DAMAGED,
        ) from error
    return {entry.msgid: entry.msgstr for entry in catalogue.translated_entries()}
