"""What is said of a survey's signature, and how much it counts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional

from gpr20_analysis import faults
from gpr20_analysis.read.verification_result import COMPLETE, DAMAGED, INCOMPLETE
from gpr20_common.message import Message
from gpr20_common.sent_message import message_fields
from gpr20_survey.folder import signature
from gpr20_survey.folder.signature import Signature, SignatureCheck

STATUS: Mapping[Signature, int] = {
    Signature.VALID: COMPLETE,
    Signature.UNSIGNED: INCOMPLETE,
    Signature.CHANGED: INCOMPLETE,
    Signature.UNKNOWN_KEY: DAMAGED,
    Signature.WRONG: DAMAGED,
}
"""The exit status that each state gives at least, if a signature is asked for."""


@dataclass(frozen=True)
class Signed:
    """The signature of a survey."""

    message: Message
    """With the fault that it reports, if any."""
    check: Optional[SignatureCheck] = None
    """None: it was not checked."""

    @property
    def status(self) -> int:
        """The exit status that it gives at least."""
        return COMPLETE if self.check is None else STATUS[self.check.signature]

    def record(self) -> Dict[str, Any]:
        """Return everything as JSON holds it."""
        return {
            "state": None if self.check is None else self.check.signature.value,
            "signer": "" if self.check is None else self.check.signer,
            "fingerprint": "" if self.check is None else self.check.fingerprint,
            **message_fields(self.message),
        }


def look_at_signature(folder: Path, signers: Optional[Path]) -> Signed:
    """Check the signature of a survey, or only say whether it has one.

    Args:
        folder: The survey's folder.
        signers: File of the keys that are accepted; None: none is asked for.

    Raises:
        SigningError: The signers file cannot be read, or ssh-keygen cannot be run.
    """
    folder = folder.expanduser()
    if signers is None:
        if signature.is_signed(folder):
            return Signed(Message("signed; by whom was not checked (give --signers)"))
        return Signed(Message("not signed"))
    check = signature.check_signature(folder, signers.expanduser())
    return Signed(_SENTENCES[check.signature](check), check)


def _valid(check: SignatureCheck) -> Message:
    return Message(
        "signed by {signer} with the key {fingerprint}",
        signer=check.signer,
        fingerprint=check.fingerprint,
    )


def _unsigned(_check: SignatureCheck) -> Message:
    return Message("NOT SIGNED: nobody vouches for the survey").with_fault(faults.UNSIGNED)


def _wrong(check: SignatureCheck) -> Message:
    return Message("WRONG SIGNATURE: {reason}", reason=check.reason).with_fault(
        faults.WRONG_SIGNATURE
    )


def _unknown(check: SignatureCheck) -> Message:
    return Message(
        "UNKNOWN KEY: signed with the key {fingerprint}, which the signers file does not accept",
        fingerprint=check.fingerprint,
    ).with_fault(faults.UNKNOWN_SIGNER)


def _changed(check: SignatureCheck) -> Message:
    return Message(
        "CHANGED AFTER IT WAS SIGNED: {signer} signed the traces and the log as it was then; "
        "nobody has signed what was added to the log since",
        signer=check.signer,
    ).with_fault(faults.CHANGED_SINCE_SIGNED)


_SENTENCES: Mapping[Signature, Callable[[SignatureCheck], Message]] = {
    Signature.VALID: _valid,
    Signature.UNSIGNED: _unsigned,
    Signature.WRONG: _wrong,
    Signature.UNKNOWN_KEY: _unknown,
    Signature.CHANGED: _changed,
}
