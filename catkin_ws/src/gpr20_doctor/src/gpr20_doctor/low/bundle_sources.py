"""The parts of a bundle: commands, the ends of files, and texts without their secrets."""

from __future__ import annotations

import codecs
import json
import os
import re
from pathlib import Path
from typing import Any, Iterator, List, Sequence, Tuple

from gpr20_survey.files.regular_file import open_regular

UNITS = ("robot", "server", "firewall", "window", "update")
# Each is short, and none changes anything.
COMMANDS: Sequence[Tuple[str, Sequence[str]]] = (
    ("system/kernel.txt", ("uname", "-a")),
    ("system/packages.txt", ("dpkg-query", "-W", "gpr20-*", "ros-*", "python3", "chrony")),
    ("system/disks.txt", ("df", "-hT")),
    ("system/mounts.txt", ("findmnt", "-l")),
    ("system/memory.txt", ("free", "-m")),
    ("system/processes.txt", ("ps", "-eo", "pid,ppid,stat,etimes,%cpu,rss,comm", "--sort=-rss")),
    ("system/addresses.txt", ("ip", "-brief", "addr")),
    ("system/routes.txt", ("ip", "route")),
    ("system/listening.txt", ("ss", "-ltn")),
    ("system/clock.txt", ("chronyc", "-n", "sources")),
    ("system/firewall.txt", ("nft", "list", "ruleset")),
    ("system/kernel_log.txt", ("dmesg", "--level=emerg,alert,crit,err,warn", "--ctime")),
    (
        "logs/services.txt",
        ("journalctl", "--no-pager", "-o", "short-iso", "-n", "3000")
        + tuple(f"--unit=gpr20-{one}" for one in UNITS),
    ),
)
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
    # A comment is a sentence, with the secret anywhere.
    (re.compile(rf"(?im)((?:^|[ \t])#)(?=[^\n]{{0,500}}?{_NAME})[^\n]*"), r"\1 "),
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


def end_of(path: Path, most_bytes: int, follow_link: bool = False) -> str:
    """Return the end of a regular file, in whole lines.

    Raises:
        OSError: It cannot be read.
        IrregularFileError: It is a link, a device or a pipe.
    """
    with open(open_regular(path, follow_link), "rb") as stream:
        skipped = max(0, os.fstat(stream.fileno()).st_size - most_bytes)
        stream.seek(skipped)
        # A file that grows does not make the bundle grow.
        text = _decoded(stream.read(most_bytes))
    return text.partition("\n")[2] if skipped else text


def _decoded(content: bytes) -> str:
    """Return a text as YAML reads it: UTF-16 too, whose secrets would not be found as UTF-8."""
    marked = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return content.decode("utf-16" if marked else "utf-8", errors="replace")


def newest(folder: Path, pattern: str) -> List[Path]:
    """Return the files below a folder, the newest first; links are left out."""
    return [path for _time, path in sorted(_dated(folder, pattern), reverse=True)]


def _dated(folder: Path, pattern: str) -> Iterator[Tuple[float, Path]]:
    for path in folder.glob(pattern):
        try:
            # The folder `latest` of roslaunch is a link to one that is listed itself.
            if not any(one.is_symlink() for one in (path, path.parent)):
                yield path.stat().st_mtime, path
        except OSError:
            continue  # it was removed in the meantime


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
