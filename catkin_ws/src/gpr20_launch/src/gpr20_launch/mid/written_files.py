"""What is written into a configuration's folder: templates of its files, and the signing key.

The templates show what the classes of the parameters say, and their defaults.
"""

from __future__ import annotations

import dataclasses
import inspect
import json
import math
import os
import re
import typing
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Type

import yaml

from gpr20_common.message import Message
from gpr20_common.mid.codec import plain
from gpr20_common.terminal_text import printable
from gpr20_launch.mid.robot_check import STORAGE_FILE
from gpr20_launch.mid.robot_files import AXES_FILE, FILES, Reading
from gpr20_survey import faults
from gpr20_survey.axes import AxisParameters
from gpr20_survey.errors import SigningError
from gpr20_survey.files import durable_files
from gpr20_survey.folder import signature
from gpr20_survey.folder.signature import NAMESPACE

HEAD = 'A key that is commented out has the default shown; remove its "#" to change it.'
# It has no ending of YAML, so no reader of the configuration opens it.
KEY_FILE = "signing_key"
# The parameter, also as the template shows it; a comment has a space behind its "#".
_PARAMETER = re.compile(r"^#?signing_key:.*$", re.MULTILINE)


def templates(built: Mapping[str, Mapping[str, Any]]) -> Dict[str, str]:
    """Return the text of each file, by its name, for a robot with the axes as it is built."""
    texts = {}
    for name, sections in FILES.items():
        lines = [f"# {name}. {HEAD}"]
        for kind in sections.values():
            lines += [*_said_by(kind), *_commented(_defaults(kind))]
        texts[name] = "\n".join([*lines, ""])
    lines = [f"# {AXES_FILE}. {HEAD}", *_said_by(AxisParameters)]
    for axis, values in built.items():
        known = {**values, **_defaults(AxisParameters), **values}
        lines += ["", f"{axis}:", *(f"  {line}" for line in _commented(known))]
    texts[AXES_FILE] = "\n".join([*lines, ""])
    return texts


def _said_by(kind: Type) -> List[str]:
    """Return what a class, and those of the groups in its lists, say of themselves."""
    items = [typing.get_args(one)[:1] for one in typing.get_type_hints(kind).values()]
    groups = [one for (one,) in filter(None, items) if dataclasses.is_dataclass(one)]
    text = "\n\n".join(inspect.getdoc(one) or "" for one in (kind, *groups))
    lines = text.replace("Attributes:", "Keys:").splitlines()
    return ["#", *(f"# {line}".rstrip() for line in lines), ""]


def _commented(values: Mapping[str, Any]) -> Iterator[str]:
    for name, value in values.items():
        text = yaml.safe_dump(value, default_flow_style=True, width=math.inf, allow_unicode=True)
        yield f"#{name}: {text.splitlines()[0]}"  # a plain value is followed by a line of dots


def _defaults(kind: Type) -> Dict[str, Any]:
    known, missing = {}, dataclasses.MISSING
    for one in dataclasses.fields(kind):
        if one.default_factory is not missing:
            known[one.name] = one.default_factory()
        elif one.default is not missing:
            known[one.name] = plain(one.default)
    return known


def ensure_key(reading: Reading) -> List[str]:
    """Make the key and name it in storage.yaml, where either is missing; change nothing else.

    Returns:
        What the person who asked reads: what was made, the line for signers files, and the
        fingerprint.

    Raises:
        SigningError: The key cannot be made, or the one that is there cannot be used.
        OSError: The disk refused.
    """
    name, named = reading.record("site").robot, reading.record("storage").signing_key
    path = Path(named).expanduser() if named else reading.folder / KEY_FILE
    said = [f"{path} exists and stays as it is"]
    if not os.path.lexists(str(path)):
        made = signature.ssh_keygen(("-q", "-t", "ed25519", "-N", "", "-C", name, "-f", path))
        if not made.yes:
            file, why = printable(path), made.complaint
            text = Message("the key {file} was not made", file=file, details=why)
            raise SigningError(text, fault=faults.NOT_SIGNED)
        durable_files.sync_path(path)
        durable_files.sync_path(path.parent)
        said = [f"{path} created: keep it on this computer only"]
    kind, key = signature.use_key(path, ("-y", "-P", "")).split()[:2]
    fingerprint = signature.use_key(path, ("-l",)).split()[1]
    if not named:
        _name_key(reading.folder / STORAGE_FILE, path)
        said.append(f"{STORAGE_FILE}: signing_key is {path}, from the next launch on")
    # What a signers file cannot hold becomes a hyphen.
    line = re.sub(r"[^A-Za-z0-9._@+-]", "-", name) + f' namespaces="{NAMESPACE}" {kind} {key}'
    fitting = ["for the signers file of those who check surveys:", "", line, ""]
    return [*said, *fitting, f"its fingerprint: {fingerprint}"]


def _name_key(path: Path, key: Path) -> None:
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    line = f"signing_key: {json.dumps(str(key), ensure_ascii=False)}"
    changed, count = _PARAMETER.subn(lambda _found: line, text, count=1)
    if not count:
        changed = "\n".join([*text.splitlines(), line, ""])
    # The configuration may be a link to where it is kept.
    durable_files.replace_file(path.resolve(), changed.encode("utf-8"))
