"""gpr20 sign: sign a survey as it is now."""

from __future__ import annotations

import argparse
from pathlib import Path

from gpr20_analysis import faults
from gpr20_analysis.commands.command import DONE, Command
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.read.checks import is_sealed, manifest_differences
from gpr20_analysis.read.verification import check_survey_folder
from gpr20_analysis.sentences import shown
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import say
from gpr20_survey.faults import CAN_RESUME
from gpr20_survey.files.folder_lock import SHORT_WAIT_S, locked
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.recovery import recover
from gpr20_survey.folder.signature import Signer

SHOWN = 5
"""Number of differences that are named."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("survey", type=Path, help="folder of a survey that has ended")
    parser.add_argument("key", type=Path, help="file of the private key, without a passphrase")


def run(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Sign a survey whose files are those of its manifest, and return the exit status.

    Raises:
        AnalysisError: It is no survey, was not closed, or its files differ from the manifest.
        SigningError: The key cannot be used; nothing was changed.
        SurveyRefusedError: Nothing describes the survey, or another process writes it.
    """
    folder, signer = chosen.survey, Signer(chosen.key)
    check_survey_folder(folder)
    signer.check()
    with locked(folder, SHORT_WAIT_S):
        survey_folder.check_no_links(folder)
        recovered = recover(folder, asking_manifest=True)
        log, sealed = recovered.found, recovered.manifest
        if sealed is None or not is_sealed(recovered):
            raise AnalysisError(
                Message("the survey is not closed, or its manifest is damaged"),
                fault=CAN_RESUME,
            )
        differences = manifest_differences(folder, recovered)
        if differences or not log.is_whole:
            damaged = [
                Message("{file} is damaged", file=one) for one in (*log.damaged, *log.behind)
            ]
            raise AnalysisError(
                Message(
                    "what differs from the manifest is not signed: {differences}",
                    differences=in_a_row([*differences, *damaged][:SHOWN]),
                ).reporting_only(faults.NOT_INTACT)
            )
        sealed.write_for(folder, log.records[-1])
        signer.sign(folder)
    say(shown(Message("the survey is signed as it is now"), catalogue))
    return DONE


COMMAND = Command(
    "Sign a survey whose files are those of its manifest, with all that was added to its log. "
    "Whoever signs vouches for it: look at what was added with gpr20 info and gpr20 verify.",
    add_arguments,
    run,
)
