"""The signature of a survey: who vouches for its manifest, and so for every file of it.

`manifest.json.sig` is a signature of the bytes of `manifest.json`, as `ssh-keygen -Y sign` makes
it. Whatever else of the survey changes, the manifest shows; whoever changes the manifest as well
cannot sign it without the robot's key. What is added to the log later is not signed until somebody
signs again.
"""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path
from typing import NamedTuple, Optional, Sequence, Tuple, Union

from gpr20_common.errors import os_reason
from gpr20_common.message import Message, verbatim
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import ProcessingError, SigningError, storing
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import check_regular, read_regular
from gpr20_survey.folder.manifest import MANIFEST_FILE, SIGNATURE_FILE

PROGRAM = "ssh-keygen"
TIMEOUT_S = 20.0
"""It hashes 500 MB in about a second, and a person waits for an annotation."""
_NO = 255
"""Its status if the answer is no: a signature that does not fit, a name that is not there."""
NAMESPACE = "gpr20-survey"
"""What the signature is for: one by the same key for another purpose does not count."""
# ssh-keygen accepts more: with this not even a space can change unseen.
_FORM = re.compile(
    rb"-----BEGIN SSH SIGNATURE-----\n[A-Za-z0-9+/=\n]{1,16384}-----END SSH SIGNATURE-----\n"
)
_FINGERPRINT = re.compile(r"SHA256:[A-Za-z0-9+/]{43}")


class Answer(NamedTuple):
    """What ssh-keygen answered: whether it did so, or found that it is so; and its words."""

    yes: bool
    output: str
    complaint: str


def ssh_keygen(arguments: Sequence[Union[str, Path]], content: bytes = b"") -> Answer:
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
        answer = ssh_keygen((*arguments, "-f", path), content)
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


class Signer:
    """Signs surveys with a private key without a passphrase, in a file."""

    def __init__(self, key: Path) -> None:
        self._key = key.expanduser().absolute()

    def check(self) -> None:
        """Find out whether the key can be used.

        Raises:
            SigningError: It cannot; the message says why and what to do.
        """
        self._signature_of(b"")

    def sign(self, folder: Path) -> None:
        """Sign the manifest of a survey as it is now; return when the signature is durable.

        Raises:
            SigningError: The key cannot be used, or ssh-keygen failed.
            StorageFailedError: The manifest cannot be read, or the disk refused the signature.
                After any error the former signature is still there, which does not fit any more.
        """
        path = folder / SIGNATURE_FILE
        with storing(Message("{path} could not be written", path=printable(path)), path):
            content = read_regular(folder / MANIFEST_FILE, follow_link=False)
            durable_files.replace_file(path, self._signature_of(content))

    def has_signed(self, folder: Path) -> bool:
        """Return whether the manifest of a survey is as this key signed it.

        What somebody else has changed must not be signed with the next change.
        """
        try:
            own = _FINGERPRINT.findall(use_key(self._key, ("-l",)))
            return signed_manifest(folder)[1] in own
        except (OSError, SigningError):
            return False  # a file is missing; or the key cannot be used, which `sign` says

    def _signature_of(self, content: bytes) -> bytes:
        sign = ("-Y", "sign", "-n", NAMESPACE)
        return use_key(self._key, sign, content).encode("ascii")


def signed_manifest(folder: Path) -> Tuple[bytes, str]:
    """Return the manifest, and the fingerprint of the key that signed it; empty: nobody did.

    Raises:
        SigningError: ssh-keygen cannot be run.
        OSError: One of the files is missing, or cannot be read.
    """
    signature = folder / SIGNATURE_FILE
    is_sound = _FORM.fullmatch(read_regular(signature, follow_link=False)) is not None
    content = read_regular(folder / MANIFEST_FILE, follow_link=False)
    fits = ssh_keygen(("-Y", "check-novalidate", "-n", NAMESPACE, "-s", signature), content)
    found = _FINGERPRINT.search(fits.output) if is_sound and fits.yes else None
    return content, "" if found is None else found.group()


def try_to_sign(signer: Optional[Signer], folder: Path) -> Optional[Message]:
    """Sign a survey after its manifest was written, if the robot has a key.

    Returns:
        A warning for the operator that the survey is stored but not signed; None otherwise.
    """
    try:
        if signer is not None:
            signer.sign(folder)
    except ProcessingError as error:
        return Message(
            "the survey is stored, but not signed: {reason}", reason=error.message
        ).as_warning()
    return None


def key_warning(signer: Optional[Signer]) -> Optional[Message]:
    """Return a warning that surveys will not be signed, if the key of a robot cannot be used."""
    try:
        if signer is not None:
            signer.check()
    except SigningError as error:
        # A survey is worth more than its signature.
        return Message("surveys are not signed: {reason}", reason=error.message).as_warning()
    return None


def is_signed(folder: Path) -> bool:
    """Return whether a survey has a signature, whatever that is worth."""
    return os.path.lexists(str(folder / SIGNATURE_FILE))
