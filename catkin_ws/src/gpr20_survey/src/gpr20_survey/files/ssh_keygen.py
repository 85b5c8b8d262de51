"""The program ssh-keygen of OpenSSH: it makes keys, signs and checks signatures."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import NamedTuple, Sequence, Union

from gpr20_common.errors import os_reason
from gpr20_common.message import Message, verbatim
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import SigningError
from gpr20_survey.files.regular_file import check_regular

PROGRAM = "ssh-keygen"
TIMEOUT_S = 20.0
"""It hashes 500 MB in about a second, and a person waits for an annotation."""
_NO = 255
"""Its status if the answer is no: a signature that does not fit, a name that is not there."""


class Answer(NamedTuple):
    """What ssh-keygen answered: whether it did so, or found that it is so; and its words."""

    yes: bool
    output: str
    complaint: str


def ask(arguments: Sequence[Union[str, Path]], content: bytes = b"") -> Answer:
    """Run ssh-keygen on a content; it can ask nobody for anything.

    Raises:
        SigningError: It is not installed, too old, did not end in time or failed itself.
    """
    # Without an agent, and without a program or a terminal on which to ask for a passphrase.
    environment = {"LC_ALL": "C", "SSH_ASKPASS_REQUIRE": "never"}
    environment["PATH"] = os.environ.get("PATH", os.defpath)
    try:
        done = subprocess.run(
            [PROGRAM, *map(str, arguments)],
            input=content,
            capture_output=True,
            env=environment,
            start_new_session=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise SigningError(
            Message("{program} did not end within {time_s:g} s", program=PROGRAM, time_s=TIMEOUT_S)
        ) from error
    except OSError as error:
        raise _cannot_run(os_reason(error)) from error
    complaint = done.stderr.decode("utf-8", "backslashreplace").strip()
    if done.returncode not in (0, _NO):
        raise _cannot_run(Message("OpenSSH 8.2 or later is needed", details=complaint))
    if "No user exists" in complaint:  # of this process, as in a container
        raise _cannot_run(verbatim(complaint))
    return Answer(done.returncode == 0, done.stdout.decode("utf-8", "backslashreplace"), complaint)


def use_key(path: Path, arguments: Sequence[str], content: bytes = b"") -> str:
    """Return what ssh-keygen says with a private key.

    Raises:
        SigningError: The key cannot be used.
    """
    try:
        check_regular(path, follow_link=True)  # it would wait for a pipe
        answer = ask((*arguments, "-f", path), content)
        if answer.yes:
            return answer.output
        reason = Message(
            "it must be a private key without a passphrase, which only its owner may read (chmod "
            "600), and {public} beside it must not be of another key",
            public=f"{path.name}.pub",
            details=answer.complaint,
        )
    except OSError as error:
        reason = os_reason(error)
    raise SigningError(
        Message(
            "the signing key {file} cannot be used: {reason}", file=printable(path), reason=reason
        ).reporting_only(faults.NOT_SIGNED)
    )


def _cannot_run(reason: Message) -> SigningError:
    return SigningError(
        Message(
            "{program} of the package openssh-client cannot be run: {reason}",
            program=PROGRAM,
            reason=reason,
        )
    )
