"""The program ssh-keygen of OpenSSH: it makes keys, signs and checks signatures."""

from __future__ import annotations

import base64
import hashlib
import os
import pwd
import shutil
import stat
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Sequence, Union

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SigningError
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_file import open_regular

PROGRAM = "ssh-keygen"
TIMEOUT_S = 20.0
"""It hashes 500 MB in about a second, and a person waits for an annotation."""
MAX_KEY_BYTES = 1 << 16
# It would ask these for a passphrase, or for another key than that of the file.
_ASKED = ("SSH_ASKPASS", "SSH_AUTH_SOCK", "SSH_SK_PROVIDER", "DISPLAY", "WAYLAND_DISPLAY")
# Its status if the answer is no: a signature that does not fit, a name that is not there.
_NO = 255


@dataclass(frozen=True)
class Answer:
    """What ssh-keygen answered."""

    yes: bool
    """Whether it did what it was asked for, or found that it is so."""
    output: str
    complaint: str
    """Its own words, for the details of a message."""


def ask(
    arguments: Sequence[Union[str, Path]], stdin: Union[int, IO[bytes]] = subprocess.DEVNULL
) -> Answer:
    """Run ssh-keygen; it can ask nobody for anything.

    Args:
        arguments: Of its command line.
        stdin: What it reads: a file, or nothing.

    Raises:
        SigningError: It is not installed, too old, did not end in time or failed itself.
    """
    program = shutil.which(PROGRAM)
    if program is None:
        raise SigningError(
            Message("the program {program} is not installed", program=PROGRAM),
            fault=faults.NO_SSH_KEYGEN,
        )
    _check_user()
    environment = {name: one for name, one in os.environ.items() if name not in _ASKED}
    environment.update(LC_ALL="C", SSH_ASKPASS_REQUIRE="never")
    try:
        done = subprocess.run(
            [program, *map(str, arguments)],
            stdin=stdin,
            capture_output=True,
            env=environment,
            # Without a terminal of its own it cannot ask there either.
            start_new_session=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise SigningError(
            Message("{program} did not end within {time_s:g} s", program=PROGRAM, time_s=TIMEOUT_S)
        ) from error
    except OSError as error:
        raise SigningError(
            Message("{program} cannot be run: {reason}", program=PROGRAM, reason=os_reason(error)),
            fault=faults.NO_SSH_KEYGEN,
        ) from error
    complaint = done.stderr.decode("utf-8", "backslashreplace").strip()
    if done.returncode not in (0, _NO):
        raise SigningError(
            Message(
                "{program} ended with status {status}; OpenSSH 8.2 or later is needed",
                program=PROGRAM,
                status=done.returncode,
                details=complaint,
            ),
            fault=faults.NO_SSH_KEYGEN,
        )
    output = done.stdout.decode("utf-8", "backslashreplace")
    return Answer(done.returncode == 0, output, complaint)


def _check_user() -> None:
    # Without an entry ssh-keygen ends as if the answer were no.
    try:
        pwd.getpwuid(os.getuid())
    except KeyError as error:
        raise SigningError(
            Message(
                "{program} does not run for user {number}, who has no name on this computer",
                program=PROGRAM,
                number=os.getuid(),
            ),
            fault=faults.NO_SSH_KEYGEN,
        ) from error


@dataclass(frozen=True)
class PublicKey:
    """The public part of a key."""

    kind: str
    """Such as ssh-ed25519."""
    blob: str
    """The key itself, base64."""

    @property
    def fingerprint(self) -> str:
        """The key's short name, as OpenSSH shows it."""
        digest = hashlib.sha256(base64.b64decode(self.blob)).digest()
        return "SHA256:" + base64.b64encode(digest).decode("ascii").rstrip("=")

    def signers_line(self, principal: str, namespace: str) -> str:
        """Return the line of a signers file that accepts signatures by this key.

        Args:
            principal: Who signs; what such a file cannot hold becomes a hyphen.
            namespace: What its signatures are for.
        """
        plain = "".join(
            one if one.isascii() and (one.isalnum() or one in "._@+-") else "-" for one in principal
        )
        return f'{plain} namespaces="{namespace}" {self.kind} {self.blob}'


def make_key(path: Path, comment: str) -> None:
    """Make a private key without a passphrase that only this user can read; it must not exist.

    Raises:
        SigningError: ssh-keygen cannot be run, or did not make it.
        FileExistsError: There is one.
        OSError: The disk refused.
    """
    if os.path.lexists(str(path)):
        raise FileExistsError(None, "exists", str(path))
    made = ask(("-q", "-t", "ed25519", "-N", "", "-C", comment, "-f", path))
    if not made.yes:
        raise SigningError(
            Message("the key {file} was not made", file=printable(path), details=made.complaint),
            fault=faults.SIGNING_KEY,
        )
    durable_files.sync_path(path)
    durable_files.sync_path(path.parent)


def check_key(path: Path) -> None:
    """Refuse a private key that is not there, or that others may read.

    Raises:
        SigningError: It cannot be used; the message says why and what to do.
    """
    try:
        descriptor = open_regular(path, follow_link=True)
    except OSError as error:
        raise _unusable(path, os_reason(error)) from error
    try:
        found = os.fstat(descriptor)
    finally:
        os.close(descriptor)
    if found.st_size > MAX_KEY_BYTES:
        raise _unusable(path, Message("it has {size} bytes", size=found.st_size))
    mode = stat.S_IMODE(found.st_mode)
    if mode & 0o077:
        raise _unusable(
            path,
            Message(
                "others than its owner may use it (mode {mode}); look who had it, then run: "
                "{command}",
                mode=f"{mode:04o}",
                command=f"chmod 600 {printable(path)}",
            ),
        )


def public_key(path: Path) -> PublicKey:
    """Return the public part of a private key.

    Raises:
        SigningError: The key cannot be used, or has a passphrase.
    """
    check_key(path)
    answer = ask(("-y", "-P", "", "-f", path))
    if not answer.yes:
        raise unreadable_key(path, answer)
    kind, blob = answer.output.split()[:2]
    return PublicKey(kind, blob)


def unreadable_key(path: Path, answer: Answer) -> SigningError:
    """Return the error about a key that ssh-keygen could not use."""
    reason = Message(
        "it is not a private key, has a passphrase, or a file beside it ({public}) is of another "
        "key",
        public=f"{path.name}.pub",
        details=answer.complaint,
    )
    return _unusable(path, reason)


def _unusable(path: Path, reason: Message) -> SigningError:
    return SigningError(
        Message(
            "the signing key {file} cannot be used: {reason}", file=printable(path), reason=reason
        ),
        fault=faults.SIGNING_KEY,
    )
