"""Messages in the language of those who read them."""

from __future__ import annotations

import enum
from typing import Mapping, Optional

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message


class Language(enum.Enum):
    """A language, by its ISO 639-1 code."""

    ENGLISH = "en"
    SPANISH = "es"

    @property
    def own_name(self) -> str:
        """What its speakers call it."""
        return {Language.ENGLISH: "English", Language.SPANISH: "Español"}[self]


def language_from_code(code: object) -> Language:
    """Return the language with a code.

    Raises:
        InvalidValueError: There is no catalogue for it.
    """
    for language in Language:
        if language.value == code:
            return language
    allowed = ", ".join(f"{one.value} ({one.own_name})" for one in Language)
    raise InvalidValueError(
        Message("language is {code}; it must be one of {allowed}", code=repr(code), allowed=allowed)
    )


def language_from_environment(environment: Mapping[str, str]) -> Language:
    """Return the language that a terminal asks for, in the order of gettext's variables.

    Args:
        environment: `os.environ` or the like; a language without a catalogue gives English.
    """
    for name in ("LANGUAGE", "LC_ALL", "LC_MESSAGES", "LANG"):
        if environment.get(name):
            code = environment[name].split(":")[0].split(".")[0].split("_")[0]
            return next((one for one in Language if one.value == code), Language.ENGLISH)
    return Language.ENGLISH


class Catalogue:
    """Translates templates, and messages with the values in them."""

    def __init__(self, translations: Optional[Mapping[str, str]] = None) -> None:
        """Make a catalogue.

        Args:
            translations: Translation of each template; without them all stays English.
        """
        self._translations = translations or {}

    def template(self, template: str) -> str:
        """Return the translation of a template; English if there is none."""
        return self._translations.get(template) or template

    def text(self, message: Message) -> str:
        """Return the sentence of a message, without its details."""
        return message.sentence(self.template)

    def tr(self, template: str, /, **values: object) -> str:
        """Return the text of a template that is written where it is shown."""
        return self.text(Message(template, **values))
