"""Who signed a survey, what is said of it, and how much it counts."""

from __future__ import annotations

import enum
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, Optional

from gpr20_analysis import errors
from gpr20_analysis.read.verdict import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_analysis.sentences import json_fields
from gpr20_common.errors import os_reason
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import IrregularFileError, ProcessingError, SigningError
from gpr20_survey.files.regular_files import read_regular
from gpr20_survey.folder import manifest
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.signature import NAMESPACE, is_signed, signed_manifest, ssh_keygen
from gpr20_survey.folder.survey_log import read_log

OF_COPIES = {Kind.BAG.value, Kind.EXPORT.value, Kind.AUDIT.value}
"""What the software notes of copies of a survey; the survey itself stays as it was signed."""


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
class Signed:
    """The signature of a survey."""

    message: Message
    """With the fault that it reports, if any."""
    state: Optional[Signature] = None
    """None: it was not checked."""
    signer: str = ""
    """Who signed, as the signers file names the key; empty unless VALID or CHANGED."""
    fingerprint: str = ""
    """Of the key, as OpenSSH shows it; empty if the signature does not fit the manifest."""

    @property
    def status(self) -> int:
        """The exit status that it gives at least, if a signature is asked for."""
        if self.state in (None, Signature.VALID):
            return COMPLETE
        is_open = self.state in (Signature.UNSIGNED, Signature.CHANGED)
        return INCOMPLETE if is_open else DAMAGED

    def record(self) -> Dict[str, Any]:
        """Return everything as JSON holds it."""
        return {
            "state": self.state and self.state.value,
            "signer": self.signer,
            "fingerprint": self.fingerprint,
            **json_fields(self.message),
        }


def look_at_signature(folder: Path, signers: Optional[Path]) -> Signed:
    """Check the signature of a survey, or only say whether it has one.

    Args:
        folder: The survey's folder.
        signers: File of the keys that are accepted; None: none is asked for.

    Raises:
        SigningError: The signers file cannot be read, or ssh-keygen cannot be run.
    """
    if signers is not None:
        return check_signature(folder.expanduser(), signers.expanduser())
    is_there = is_signed(folder.expanduser())
    text = Message("signed; by whom was not checked (give --signers)")
    return Signed(text if is_there else Message("not signed"))


def check_signature(folder: Path, signers: Path) -> Signed:
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
    try:
        read_regular(signers)  # a pipe could be read only once
    except OSError as error:
        raise SigningError(
            Message(
                "the signers file {file} cannot be read: {reason}; give another with --signers",
                file=printable(signers),
                reason=os_reason(error),
            ).reporting_only(NOT_ALLOWED)
        ) from error
    try:
        content, fingerprint = signed_manifest(folder)
    except FileNotFoundError:
        # Without a manifest the survey is open, or verification calls it damaged.
        text = Message("NOT SIGNED: nobody vouches for the survey")
        return Signed(text.with_fault(errors.UNSIGNED), Signature.UNSIGNED)
    except IrregularFileError as error:
        file, reason = printable(Path(error.filename).name), os_reason(error)
        return _wrong(Message("{file} cannot be read: {reason}", file=file, reason=reason))
    if not fingerprint:
        return _wrong(
            Message(
                "{signature} does not fit {manifest}: one of them was changed or written again",
                signature=manifest.SIGNATURE_FILE,
                manifest=manifest.MANIFEST_FILE,
            )
        )
    signature = folder / manifest.SIGNATURE_FILE
    for principal in _principals(signature, signers):
        own = ("-n", NAMESPACE, "-s", signature, "-f", signers, "-I", principal)
        if ssh_keygen(("-Y", "verify", *own), content).yes:
            return _with_log(folder, content, principal, fingerprint)
    # Also a key that is listed for other purposes.
    text = Message(
        "UNKNOWN KEY: signed with the key {fingerprint}, which the signers file does not accept",
        fingerprint=fingerprint,
    )
    unknown = Signature.UNKNOWN_KEY
    return Signed(text.with_fault(errors.UNKNOWN_SIGNER), unknown, fingerprint=fingerprint)


def _with_log(folder: Path, content: bytes, signer: str, fingerprint: str) -> Signed:
    """Return what is known of a valid signature by what was added to the log since."""
    try:
        since = manifest.decode(content).since(read_log(folder).records)
    except ProcessingError as error:
        return _wrong(error.message)
    kinds = {one.kind for one in since}
    if Kind.RESUME.value in kinds:
        # The files may be others than the signed manifest lists.
        return _wrong(Message("the survey was reopened after it was signed"))
    if not kinds - OF_COPIES:
        text = Message(
            "signed by {signer} with the key {fingerprint}", signer=signer, fingerprint=fingerprint
        )
        return Signed(text, Signature.VALID, signer, fingerprint)
    text = Message(
        "CHANGED AFTER IT WAS SIGNED: {signer} signed the traces and the log as it was then; "
        "nobody has signed what was added to the log since",
        signer=signer,
    ).with_fault(errors.CHANGED_SINCE_SIGNED)
    return Signed(text, Signature.CHANGED, signer, fingerprint)


def _principals(signature: Path, signers: Path) -> Iterator[str]:
    """Yield the names for which a signers file accepts the key of a signature."""
    found = ssh_keygen(("-Y", "find-principals", "-s", signature, "-f", signers))
    for line in found.output.splitlines() if found.yes else ():
        # A pattern such as "!R2,*" names nobody by its first part.
        if line.strip() and not line.startswith("!"):
            yield line.strip()


def _wrong(reason: Message) -> Signed:
    text = Message("WRONG SIGNATURE: {reason}", reason=reason)
    return Signed(text.reporting_only(errors.WRONG_SIGNATURE), Signature.WRONG)
