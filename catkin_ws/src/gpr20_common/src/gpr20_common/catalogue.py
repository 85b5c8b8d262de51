"""Messages in the language of those who read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Mapping, Optional

from gpr20_common.message import Message


@dataclass(frozen=True)
class Language:
    """A language that has a catalogue; `gpr20_common.low.catalogue_file.languages` finds them.

    Attributes:
        value: ISO 639-1 code, with or without a country: es, pt_BR.
        own_name: What its speakers call it.
    """

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
