"""The language of the window, which changes at once."""

from __future__ import annotations

from typing import Optional

from PyQt5.QtCore import QCoreApplication, QTranslator

from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.message import Message, numeral


def shown_text(message: Message) -> str:
    """Return the sentence of a message in the language of the application."""
    # The translator ignores the context.
    return message.sentence(lambda template: QCoreApplication.translate("Message", template))


def shown_number(value: float, form: str = "g") -> str:
    """Return a number alone in the language of the application."""
    return shown_text(numeral(value, form))


def sentence_text(message: Message) -> str:
    """Return a message as a sentence of its own: most are written for the middle of one."""
    text = shown_text(message)
    return text[:1].upper() + text[1:]


class Languages:
    """Sets the language of the application.

    Attributes:
        language: The language now.
    """

    def __init__(self, application: QCoreApplication, language: Language) -> None:
        """Begin with a language.

        Raises:
            InvalidValueError: Its catalogue cannot be read.
        """
        self._application = application
        self._translator: Optional[QTranslator] = None
        self.language = Language.ENGLISH
        self.use(language)

    def use(self, language: Language) -> None:
        """Change the language of every widget.

        Raises:
            InvalidValueError: Its catalogue cannot be read.
        """
        translator = _CatalogueTranslator(read_catalogue(language))
        self.language = language
        self.close()
        self._application.installTranslator(translator)
        self._translator = translator

    def close(self) -> None:
        """Remove the translator of this object from the application."""
        if self._translator is not None:
            self._application.removeTranslator(self._translator)
            self._translator = None


class _CatalogueTranslator(QTranslator):
    """Looks texts up in the catalogue of all sentences, whatever their context."""

    def __init__(self, catalogue: Catalogue) -> None:
        super().__init__()
        self._catalogue = catalogue

    def isEmpty(self) -> bool:  # noqa: N802
        # Qt would not ask an empty translator.
        return False

    def translate(
        self, context: str, source: str, disambiguation: Optional[str] = None, n: int = -1
    ) -> str:
        return self._catalogue.template(source)
