"""The language of the window, which changes at once."""

from __future__ import annotations

import enum
from typing import Dict, Optional, Tuple

from PyQt5.QtCore import QCoreApplication, QEvent, QTranslator
from PyQt5.QtWidgets import QWidget

from gpr20_user_interface.errors import LanguageError
from gpr20_user_interface.low.translation_file import FOLDER, read_translations


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


class TranslatedWidget(QWidget):
    """A widget that writes its texts anew when the language changes."""

    def retranslate(self) -> None:
        """Write every text that does not come with the next refresh."""
        raise NotImplementedError(f"{type(self).__name__} does not translate itself")

    def changeEvent(self, event: QEvent) -> None:  # noqa: N802
        """Qt: something about the widget has changed."""
        if event.type() == QEvent.Type.LanguageChange:
            self.retranslate()
        super().changeEvent(event)


class Languages:
    """Puts a language on the application.

    Attributes:
        language: The language now.
    """

    def __init__(self, application: QCoreApplication, language: Language) -> None:
        """Begin with a language.

        Raises:
            LanguageError: Its translations cannot be read.
        """
        self._application = application
        self._translator: Optional[_Translator] = None
        self.language = Language.ENGLISH
        self.use(language)

    def use(self, language: Language) -> None:
        """Change the language of every widget.

        Raises:
            LanguageError: Its translations cannot be read.
        """
        translator = _translator(language)
        self.language = language
        if self._translator is not None:
            self._application.removeTranslator(self._translator)
        if translator is not None:
            self._application.installTranslator(translator)
        self._translator = translator

    def use_next(self) -> None:
        """Change to the next language."""
        self.use(self.language.next)

    def close(self) -> None:
        """Leave the application without a translator of this object."""
        if self._translator is not None:
            self._application.removeTranslator(self._translator)
            self._translator = None


class _Translator(QTranslator):
    def __init__(self, messages: Dict[Tuple[str, str], str]) -> None:
        super().__init__()
        self._messages = messages

    def isEmpty(self) -> bool:  # noqa: N802
        return not self._messages

    def translate(  # type: ignore[override]
        self, context: str, source: str, disambiguation: Optional[str] = None, n: int = -1
    ) -> Optional[str]:
        # None, which Qt's own declaration does not know, makes it take the source; an empty
        # text would be shown as such, and STOP be a button without a word.
        return self._messages.get((context, source))


def _translator(language: Language) -> Optional[_Translator]:
    # The texts in the code are the English ones.
    if language is Language.ENGLISH:
        return None
    return _Translator(read_translations(FOLDER / f"{language.value}.ts"))
