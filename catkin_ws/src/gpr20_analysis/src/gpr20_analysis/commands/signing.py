"""Signing a survey again after a command has changed it."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Optional

from gpr20_analysis.commands.command import DONE, NOT_COMPLETE
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message
from gpr20_common.terminal_text import say
from gpr20_survey.folder.signature import Signer, is_signed, try_to_sign


def add_argument(parser: argparse.ArgumentParser) -> None:
    """Declare the option that names a key."""
    parser.add_argument(
        "--sign",
        type=Path,
        metavar="KEY",
        help="sign the changed survey with this private key; without it, a signature that the "
        "survey has is of an earlier state",
    )


def chosen_signer(chosen: argparse.Namespace) -> Optional[Signer]:
    """Return who signs; None: nobody.

    Raises:
        SigningError: The key cannot be used; nothing was changed.
    """
    if chosen.sign is None:
        return None
    signer = Signer(chosen.sign)
    signer.check()
    return signer


def sign_again(folder: Path, signer: Optional[Signer], catalogue: Catalogue) -> int:
    """Sign a survey that was just changed, say what its signature is now, return the status."""
    said, status = None, DONE
    if signer is not None:
        warning = try_to_sign(signer, folder)
        said = warning or Message("the survey was signed again")
        status = DONE if warning is None else NOT_COMPLETE
    elif is_signed(folder):
        said = Message(
            "the survey's signature is of an earlier state now: --sign signs it again, with a key "
            "that its readers accept"
        )
    if said is not None:
        say(shown(said, catalogue))
    return status
