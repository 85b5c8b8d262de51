"""Reading an argument of a command line, with messages in the language of the user."""

from __future__ import annotations

import argparse
from typing import Any, Callable

from gpr20_common.catalogue import Catalogue
from gpr20_common.errors import InvalidValueError


def argument_reader(read: Callable[[str], Any], catalogue: Catalogue) -> Callable[[str], Any]:
    """Return a function for argparse that reads an argument.

    Args:
        read: Reads it; raises InvalidValueError if it is not allowed.
        catalogue: Language of the messages.
    """

    def read_argument(text: str) -> Any:
        try:
            return read(text)
        except InvalidValueError as error:
            # argparse shows the text of this error, but not that of a ValueError.
            raise argparse.ArgumentTypeError(catalogue.text(error.message)) from None

    return read_argument
