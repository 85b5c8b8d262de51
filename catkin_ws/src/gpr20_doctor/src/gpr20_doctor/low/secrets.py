"""Leaving secrets out of texts that leave this computer."""

from __future__ import annotations

import json
import re
from typing import Any

REMOVED = "[REMOVED]"
# In English and Spanish, and as programs shorten them.
_WORDS = (
    r"pass[_ -]?(?:word|wd|phrase|code)|(?<![a-z])pass(?![a-z])|pwd|(?<![a-z])pw(?![a-z])|secret"
    r"|token|api[_-]?key|private[_-]?key|psk|credential|(?<![a-z])creds?(?![a-z])|cookie|community"
    r"|(?<![a-z])otp(?![a-z])|contrase\u00f1a|(?<![a-z])clave(?![a-z])"
)
# It begins where a word begins: a line of a million letters must not take minutes.
_NAME = rf"(?<![\w-])[\w-]*(?:{_WORDS})[\w-]*"
# What classes of other makers are given may hold anything.
_KEY = rf"(?:{_NAME}|(?<![\w-])\w*options)"
# The name alone: what follows is on the next lines, further in or a list.
_BLOCK = re.compile(
    rf"(?im)^([ \t]*)(#?[ \t]*[\"']?{_KEY}[\"']?[ \t]*:)[ \t]*(?:[|>][-+\d]*)?[ \t]*"
    r"(?:#.*)?\n(?:(?:\1[ \t]+|\1-).*(?:\n|\Z)|[ \t]*\n)+"
)
_VALUE = r"(?:is\s+)?[^\s\"'\\,\[\]{}]+"
_PATTERNS = (
    # A block without its end is left out to the end.
    (re.compile(r"(?s)-----BEGIN [^\n]*KEY-----.*?(?:-----END [^\n]*KEY-----|\Z)"), REMOVED),
    (_BLOCK, rf"\1\2 {REMOVED}\n"),
    (re.compile(rf"(?i)({_NAME}[\"']?\s*,\s*[\"']?value[\"']?\s*[:=]\s*).+"), r"\1"),
    (re.compile(rf"(?im)({_KEY}[\"']?\s*[:=][ \t]*)(?:\"(?:\\.|[^\"\\])*\"|'[^']*'|.+)"), r"\1"),
    # In a sentence, a list, a command line or an escaped text: the next word.
    (re.compile(rf"(?i)({_NAME}[\\\"',:=\[ \t]+){_VALUE}"), r"\1"),
    (re.compile(r"(?i)(authorization[\"']?\s*[:=]\s*).+"), r"\1"),
    (re.compile(r"(?i)\b(bearer|basic)\s+[\w.~+/=-]{8,}"), r"\1 "),
    (re.compile(r"(?i)\b([a-z][a-z0-9+.-]*://)[^/\s@]+@"), r"\1"),
    (re.compile(r"(?i)([?&](?:sig|signature|key|auth)=)[^&\s]+"), r"\1"),
    (re.compile(r"(\bsshpass\s+-p\s*|\bcurl\b[^\n]{0,200}?\s(?:-u|--user)[\s=]+)\S+"), r"\1"),
    (re.compile(r"\b(?:eyJ[\w-]+\.[\w-]+\.[\w-]*|gh[a-z]_\w{20,})"), REMOVED),
)
_SECRET_KEY = re.compile(_KEY, re.IGNORECASE)


def without_secrets(text: str) -> str:
    """Return a text, such as a log or a YAML file, without what looks like a secret."""
    for pattern, kept in _PATTERNS:
        end = "" if REMOVED in kept else REMOVED
        text = pattern.sub(kept + end, text)
    return text


def json_without_secrets(text: str) -> str:
    """Return a JSON text without the values of keys that name a secret; other text as above."""
    try:
        return json.dumps(_cleaned(json.loads(text)), ensure_ascii=False)
    except (ValueError, RecursionError):
        return without_secrets(text)


def _cleaned(value: Any) -> Any:
    if isinstance(value, dict):
        return {
            key: REMOVED if _SECRET_KEY.fullmatch(key) else _cleaned(one)
            for key, one in value.items()
        }
    if isinstance(value, list):
        return [_cleaned(one) for one in value]
    return without_secrets(value) if isinstance(value, str) else value
