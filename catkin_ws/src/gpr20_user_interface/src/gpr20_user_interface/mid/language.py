"""The languages of the window."""

from __future__ import annotations

import enum

from gpr20_user_interface.errors import LanguageError


class Language(enum.Enum):
    """A language, by its ISO 639-1 code."""

    ENGLISH = "en"
    SPANISH = "es"

    @property
    def own_name(self) -> str:
        """What its speakers call it."""
        return _OWN_NAMES[self]

    @property
    def next(self) -> Language:
        """The language that follows in a round through all."""
        every = list(Language)
        return every[(every.index(self) + 1) % len(every)]


_OWN_NAMES = {Language.ENGLISH: "English", Language.SPANISH: "Español"}


def language_from_code(code: str) -> Language:
    """Return the language with a code.

    Raises:
        LanguageError: The window does not speak it.
    """
    try:
        return Language(code)
    except ValueError:
        allowed = ", ".join(f"{one.value} ({one.own_name})" for one in Language)
        raise LanguageError(f"language is {code!r}; it must be one of {allowed}") from None
