"""The key that signs a robot's surveys, beside the files of its configuration."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import List

from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_launch.mid.robot_check import STORAGE_FILE
from gpr20_launch.mid.robot_files import Reading
from gpr20_survey import faults
from gpr20_survey.errors import SigningError
from gpr20_survey.files import durable_files, ssh_keygen
from gpr20_survey.folder.signature import NAMESPACE

# It has no ending of YAML, so no reader of the configuration opens it.
KEY_FILE = "signing_key"
# The parameter, also as the template shows it; a comment has a space behind its "#".
_PARAMETER = re.compile(r"^#?signing_key:.*$", re.MULTILINE)


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
        made = ssh_keygen.ask(("-q", "-t", "ed25519", "-N", "", "-C", name, "-f", path))
        if not made.yes:
            file, why = printable(path), made.complaint
            text = Message("the key {file} was not made", file=file, details=why)
            raise SigningError(text, fault=faults.NOT_SIGNED)
        durable_files.sync_path(path)
        durable_files.sync_path(path.parent)
        said = [f"{path} created: keep it on this computer only"]
    kind, key = ssh_keygen.use_key(path, ("-y", "-P", "")).split()[:2]
    fingerprint = ssh_keygen.use_key(path, ("-l",)).split()[1]
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
