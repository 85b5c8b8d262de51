"""Messages in the language of those who read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Mapping, Optional

from gpr20_common.message import Message


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
        """Return the sentence of a message, without its details."""
        return message.sentence(self.template)

    def tr(self, template: str, /, **values: object) -> str:
        """Return the text of a template that is written where it is shown."""
        return self.text(Message(template, **values))
