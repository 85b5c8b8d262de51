"""The signature of a survey: who vouches for its manifest, and so for every file of it.

`manifest.json.sig` is a signature of the bytes of `manifest.json`, as `ssh-keygen -Y sign` makes
it. Whatever else of the survey changes, the manifest shows; whoever changes the manifest as well
cannot sign it without the robot's key. What is added to the log later is not signed until somebody
signs again.
"""

from __future__ import annotations

import base64
import binascii
import enum
import os
import re
import subprocess
import textwrap
from dataclasses import dataclass, replace
from pathlib import Path
from typing import IO, List, Optional, Union

from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_common.terminal_text import printable
from gpr20_survey import faults
from gpr20_survey.errors import (
    IrregularFileError,
    ManifestDamagedError,
    ProcessingError,
    SigningError,
    storing,
)
from gpr20_survey.files import durable_files, ssh_keygen
from gpr20_survey.files.regular_file import open_regular
from gpr20_survey.folder import manifest
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.manifest import MANIFEST_FILE, SIGNATURE_FILE
from gpr20_survey.folder.survey_log import read_log

NAMESPACE = "gpr20-survey"
"""What the signature is for: one by the same key for another purpose does not count."""
OF_COPIES = {Kind.BAG.value, Kind.EXPORT.value, Kind.AUDIT.value}
"""What the software notes of copies of a survey; the survey itself stays as it was signed."""
MAX_BYTES = 1 << 14
"""Size of a signature; that of the longest RSA key has 3 kB."""
MAX_SIGNERS_BYTES = 1 << 24

_BEGIN, _END = "-----BEGIN SSH SIGNATURE-----", "-----END SSH SIGNATURE-----"
_WIDTH = 70
_FINGERPRINT = re.compile(r"SHA256:[A-Za-z0-9+/]{43}")


class Signature(enum.Enum):
    """What is known of a survey's signature."""

    UNSIGNED = "unsigned"
    """There is no signature, or no manifest."""
    VALID = "valid"
    """The manifest is as a signer of the list signed it."""
    WRONG = "wrong"
    """The manifest or the signature is damaged."""
    UNKNOWN_KEY = "unknown key"
    """It is by a key that the list does not accept."""
    CHANGED = "changed after it was signed"
    """As VALID, and facts were added to the log since, for which nobody vouches."""


@dataclass(frozen=True)
class SignatureCheck:
    """The result of the check of a signature."""

    signature: Signature
    signer: str = ""
    """Who signed, as the signers file names the key; empty unless VALID or CHANGED."""
    fingerprint: str = ""
    """Of the key, as OpenSSH shows it; empty if the signature does not fit the manifest."""
    reason: Optional[Message] = None
    """Why it is WRONG."""


class Signer:
    """Signs surveys with a key; nothing is asked for, and no agent is used."""

    def __init__(self, key: Path) -> None:
        """Nothing is read yet.

        Args:
            key: File of the private key, without a passphrase.
        """
        self._key = key.expanduser().absolute()

    def check(self) -> None:
        """Find out whether the key can be used.

        Raises:
            SigningError: It cannot; the message says why and what to do.
        """
        self._signature_of(subprocess.DEVNULL)

    def sign(self, folder: Path) -> None:
        """Sign the manifest of a survey as it is now; return when the signature is durable.

        Args:
            folder: The survey's folder. Its manifest must not change meanwhile.

        Raises:
            SigningError: The key cannot be used, ssh-keygen failed, or there is no manifest.
            StorageFailedError: The manifest cannot be read, or the disk refused the signature.
                After any error the former signature is still there, which does not fit any more.
        """
        path = folder / SIGNATURE_FILE
        with storing(Message("{path} could not be written", path=printable(path)), path):
            try:
                content = open(open_regular(folder / MANIFEST_FILE), "rb")  # noqa: SIM115
            except FileNotFoundError as error:
                raise SigningError(
                    Message("the survey is not closed: it has no {file}", file=MANIFEST_FILE),
                    fault=faults.NOT_CLOSED,
                ) from error
            with content:
                signature = self._signature_of(content)
            durable_files.replace_file(path, signature)

    def has_signed(self, folder: Path) -> bool:
        """Return whether the manifest of a survey is as this key signed it.

        What somebody else has changed must not be signed with the next change.
        """
        try:
            own = ssh_keygen.public_key(self._key).fingerprint
            _check_form(folder / SIGNATURE_FILE)
            with open(open_regular(folder / MANIFEST_FILE), "rb") as stream:
                return _fingerprint(stream, folder / SIGNATURE_FILE) == own
        except OSError:
            return False  # one of the files is missing, or cannot be read
        except SigningError:
            return False  # the key cannot be used, which `sign` says, or the signature is damaged

    def _signature_of(self, content: Union[int, IO[bytes]]) -> bytes:
        ssh_keygen.check_key(self._key)
        signed = ssh_keygen.ask(("-Y", "sign", "-f", self._key, "-n", NAMESPACE), content)
        if not signed.yes:
            raise ssh_keygen.unreadable_key(self._key, signed)
        return _encode(_decode(signed.output))


def try_to_sign(signer: Optional[Signer], folder: Path) -> Optional[Message]:
    """Sign a survey after its manifest was written; a failure prevents nothing.

    Args:
        signer: Of the robot; None: it has no key, and its surveys are not signed.
        folder: The survey's folder, which holds its new manifest.

    Returns:
        A warning for the operator that the survey is stored but not signed; None otherwise.
    """
    if signer is None:
        return None
    try:
        signer.sign(folder)
    except ProcessingError as error:
        return Message(
            "the survey is stored, but not signed: {reason}", reason=error.message
        ).as_warning()
    return None


def key_warning(signer: Optional[Signer]) -> Optional[Message]:
    """Return a warning that surveys will not be signed, if the key of a robot cannot be used."""
    if signer is None:
        return None
    try:
        signer.check()
    except SigningError as error:
        # A survey is worth more than its signature.
        return Message("surveys are not signed: {reason}", reason=error.message).as_warning()
    return None


def is_signed(folder: Path) -> bool:
    """Return whether a survey has a signature, whatever that is worth."""
    return os.path.lexists(str(folder / SIGNATURE_FILE))


def check_signature(folder: Path, signers: Path) -> SignatureCheck:
    """Find out who signed a survey; nothing in its folder is changed.

    Only the signature is checked. Whether the survey's files are those of the manifest is another
    question.

    Args:
        folder: The survey's folder.
        signers: Whose keys are accepted, in OpenSSH's format (ALLOWED SIGNERS in ssh-keygen(1)).

    Raises:
        SigningError: The signers file cannot be read, or ssh-keygen cannot be run.
        OSError: The disk cannot be read.
    """
    _check_signers(signers)
    try:
        _check_form(folder / SIGNATURE_FILE)
        with open(open_regular(folder / MANIFEST_FILE), "rb") as stream:
            size = os.fstat(stream.fileno()).st_size
            if size > manifest.MAX_BYTES:
                return _wrong(Message("{file} has {size} bytes", file=MANIFEST_FILE, size=size))
            found = _check(stream, folder / SIGNATURE_FILE, signers)
    except FileNotFoundError:
        # Without a manifest the survey is open, or verification calls it damaged.
        return SignatureCheck(Signature.UNSIGNED)
    except _SignatureDamagedError as error:
        return _wrong(error.message)
    except IrregularFileError as error:
        file = printable(Path(error.filename).name)
        return _wrong(
            Message("{file} cannot be read: {reason}", file=file, reason=os_reason(error))
        )
    return _with_log(folder, found) if found.signature is Signature.VALID else found


def _with_log(folder: Path, signed: SignatureCheck) -> SignatureCheck:
    """Return what is known of a valid signature by what was added to the log since."""
    since = manifest.read_manifest(folder).since(read_log(folder).records)
    kinds = {one.kind for one in since}
    if Kind.RESUME.value in kinds:
        # The files may be others than the signed manifest lists.
        return _wrong(Message("the survey was reopened after it was signed"))
    return replace(signed, signature=Signature.CHANGED) if kinds - OF_COPIES else signed


def _fingerprint(content: IO[bytes], signature: Path) -> str:
    """Return the fingerprint of the key that signed these bytes; empty: nobody did."""
    fits = ssh_keygen.ask(("-Y", "check-novalidate", "-n", NAMESPACE, "-s", signature), content)
    return "".join(_FINGERPRINT.findall(fits.output)[:1]) if fits.yes else ""


def _check(content: IO[bytes], signature: Path, signers: Path) -> SignatureCheck:
    fingerprint = _fingerprint(content, signature)
    if not fingerprint:
        content.seek(0)
        try:
            manifest.decode(content.read())
            reason = Message("the manifest was written again since")
        except ManifestDamagedError as error:
            reason = error.message
        return _wrong(Message("{file}: {reason}", file=MANIFEST_FILE, reason=reason))
    principals = _principals(signature, signers)
    if not principals:
        return SignatureCheck(Signature.UNKNOWN_KEY, fingerprint=fingerprint)
    for principal in principals:
        content.seek(0)
        own = ("-n", NAMESPACE, "-s", signature, "-f", signers, "-I", principal)
        if ssh_keygen.ask(("-Y", "verify", *own), content).yes:
            return SignatureCheck(Signature.VALID, principal, fingerprint)
    # Such as a key that is listed for other purposes.
    return SignatureCheck(Signature.UNKNOWN_KEY, fingerprint=fingerprint)


def _principals(signature: Path, signers: Path) -> List[str]:
    found = ssh_keygen.ask(("-Y", "find-principals", "-s", signature, "-f", signers))
    # A pattern such as "!R2,*" names nobody by its first part.
    names = [line.strip() for line in found.output.splitlines() if not line.startswith("!")]
    return [one for one in names if one] if found.yes else []


def _check_signers(path: Path) -> None:
    try:
        # A person named it: it may be a link. A pipe could be read only once.
        descriptor = open_regular(path, follow_link=True)
    except OSError as error:
        raise _no_signers(path, os_reason(error)) from error
    try:
        size = os.fstat(descriptor).st_size
    finally:
        os.close(descriptor)
    if size > MAX_SIGNERS_BYTES:
        raise _no_signers(path, Message("it has {size} bytes", size=size))


def _no_signers(path: Path, reason: Message) -> SigningError:
    return SigningError(
        Message(
            "the signers file {file} cannot be read: {reason}", file=printable(path), reason=reason
        ),
        fault=faults.SIGNERS_FILE,
    )


class _SignatureDamagedError(SigningError, ValueError):
    fault = faults.NOT_SIGNED


def _check_form(signature: Path) -> None:
    with open(open_regular(signature), "rb") as stream:
        content = stream.read(MAX_BYTES + 1)
    # Equal to the last byte: not even a space can change unseen.
    if len(content) > MAX_BYTES or _encode(_decode(content.decode("ascii", "replace"))) != content:
        raise _SignatureDamagedError(Message("{file} is damaged", file=SIGNATURE_FILE))


def _decode(text: str) -> bytes:
    """Return what is between the first and the last line of a signature."""
    begin, _line, rest = text.partition("\n")
    body, end, _rest = rest.partition(f"\n{_END}")
    try:
        if begin.strip() != _BEGIN or not end:
            raise ValueError("it has other lines")
        return base64.b64decode("".join(body.split()), validate=True)
    except (ValueError, binascii.Error) as error:
        raise _SignatureDamagedError(
            Message("{file} is damaged", file=SIGNATURE_FILE, details=error)
        ) from error


def _encode(blob: bytes) -> bytes:
    """Return the one form of a signature that is written and read: that of OpenSSH."""
    body = textwrap.wrap(base64.b64encode(blob).decode("ascii"), _WIDTH)
    return "\n".join([_BEGIN, *body, _END, ""]).encode("ascii")


def _wrong(reason: Message) -> SignatureCheck:
    return SignatureCheck(Signature.WRONG, reason=reason)
