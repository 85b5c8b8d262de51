"""What a browser has sent, checked: path, query, JSON object and language."""

from __future__ import annotations

import json
from typing import Any, Dict, Mapping
from urllib.parse import parse_qsl, unquote, urlsplit

from gpr20_common.catalogue import Language, language_from_code, languages, read_catalogue
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_web.errors import BadRequestError

NO_TEXT = Message("the address is no text")
# More than any page sends; longer headers are cut.
MAX_FIELDS = 32
MAX_LANGUAGES_CHARACTERS = 200


def path_of(address: str) -> str:
    """Return the path of an address without its percent signs.

    Raises:
        BadRequestError: It is no text.
    """
    try:
        found = unquote(urlsplit(address).path, errors="strict")
    except ValueError as error:
        raise BadRequestError(NO_TEXT) from error
    if not found.isprintable():
        raise BadRequestError(NO_TEXT)
    return found


def query_of(text: str) -> Dict[str, str]:
    """Return the fields behind the question mark of an address.

    Raises:
        BadRequestError: They are no text, or too many.
    """
    try:
        fields = parse_qsl(text, keep_blank_values=True, errors="strict", max_num_fields=MAX_FIELDS)
    except ValueError as error:
        raise BadRequestError(
            Message("the address is no text, or has more than {most} fields", most=MAX_FIELDS)
        ) from error
    return dict(fields)


def object_of(body: bytes) -> Mapping[str, Any]:
    """Return the JSON object of a body; without a body it is empty.

    Raises:
        BadRequestError: It is something else.
    """
    try:
        values = json.loads(body or b"{}", parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise BadRequestError(Message("the request is not JSON")) from error
    if not isinstance(values, dict):
        raise BadRequestError(Message("the request is no JSON object"))
    return values


def _refuse_constant(name: str) -> None:
    raise ValueError(name)


def language_of(code: str, accepted: str) -> Language:
    """Return the language that a page asks for, else one that its browser accepts, else English.

    Args:
        code: Of the page.
        accepted: The browser's header Accept-Language.
    """
    names = accepted[:MAX_LANGUAGES_CHARACTERS].replace(";", ",").split(",")
    known = {one.value for one in languages()}
    wanted = (one.strip().partition("-")[0].lower() for one in (code, *names))
    found = next((one for one in wanted if one in known), Language.ENGLISH.value)
    try:
        language = language_from_code(found)
        read_catalogue(language)
    except InvalidValueError:
        # The catalogue was damaged since: a page in English is better than none.
        return Language.ENGLISH
    return language
