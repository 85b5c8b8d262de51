"""gpr20 info, verify and sign: what a survey holds, whether it is whole, and who vouches for it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from gpr20_analysis import errors
from gpr20_analysis.commands import arguments
from gpr20_analysis.commands.command import DONE, Command, print_rows
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.report.summary import summarize, summary_of, warnings_of
from gpr20_analysis.sentences import (
    DOUBTS,
    LIST_ATTRIBUTES,
    NOTES,
    first_steps,
    json_fields,
    labelled,
    shown,
)
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, in_a_row
from gpr20_common.terminal_text import say

SHOWN = 5
"""Number of differences that are named."""


def _add_info(parser: argparse.ArgumentParser) -> None:
    arguments.add_survey(parser)
    parser.add_argument("--json", action="store_true", help="print JSON, for programs")


def _info(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    survey = arguments.load(chosen, catalogue)
    if chosen.json:
        lists = {name: survey.attrs.get(name, []) for name in LIST_ATTRIBUTES}
        lists["warnings"] = [str(one) for one in warnings_of(survey)]
        print(json.dumps({**summarize(survey), **lists}, indent=2))  # noqa: T201
    else:
        print_rows(summary_of(survey), catalogue)
        for one in warnings_of(survey):
            say(shown(one, catalogue))
    return arguments.status_of(survey)


def _add_verify(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("folder", type=Path, help="folder of one survey")
    add("--signers", type=Path, metavar="FILE",
        help="require a signature by a key of this file (allowed_signers of OpenSSH)",
        )  # fmt: skip
    add("--repair", action="store_true",
        help="write manifest.json or a file of the log of a closed survey again if it is missing "
        "or damaged and all else agrees; what nothing vouches for is named for ever, and gpr20 "
        "sign signs the new manifest")  # fmt: skip
    add("--json", action="store_true", help="print JSON, for programs")


def _verify(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    from gpr20_analysis.read.repair import repair_survey
    from gpr20_analysis.read.signature import look_at_signature
    from gpr20_analysis.read.verification import verify_survey

    progress = arguments.progress_bar("verifying")
    folder = chosen.folder.expanduser()
    repaired = repair_survey(folder, progress) if chosen.repair else []
    signed = look_at_signature(folder, chosen.signers)
    found = verify_survey(folder, progress)
    status = max(found.status, signed.status)
    if chosen.json:
        record = {**found.record(), "status": status, "signature": signed.record()}
        record["repair"] = [json_fields(one) for one in repaired]
        print(json.dumps(record, indent=2))  # noqa: T201
        return status
    lines = [Message("FAULT: {sentence}", sentence=fault) for fault in found.faults]
    notes = [*repaired, *found.notes, *([] if signed.state else [signed.message])]
    for name, sentences in ((DOUBTS, found.doubts), (NOTES, notes)):
        lines += [labelled(name, one) for one in sentences]
    lines += [found.verdict, *first_steps(found.verdict)]
    # Last, so that "complete" is never the last word on what nobody vouches for.
    if signed.state:
        lines += [signed.message, *first_steps(signed.message)]
    say(*(shown(line, catalogue) for line in lines))
    return status


def _add_sign(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("survey", type=Path, help="folder of a survey that has ended")
    parser.add_argument("key", type=Path, help="file of the private key, without a passphrase")


def _sign(chosen: argparse.Namespace, catalogue: Catalogue) -> int:
    """Sign a survey whose files are those of its manifest.

    Raises:
        AnalysisError: It is no survey, was not closed, or its files differ from the manifest.
        SigningError: The key cannot be used; nothing was changed.
        SurveyRefusedError: Nothing describes the survey, or another process writes it.
    """
    from gpr20_analysis.read.checks import is_sealed, manifest_differences
    from gpr20_analysis.read.verification import check_survey_folder
    from gpr20_survey.faults import CAN_RESUME
    from gpr20_survey.files.durable_files import SHORT_WAIT_S, locked
    from gpr20_survey.folder import survey_folder
    from gpr20_survey.folder.recovery import recover
    from gpr20_survey.folder.signature import Signer

    folder, signer = chosen.survey, Signer(chosen.key)
    check_survey_folder(folder)
    signer.check()
    with locked(folder, SHORT_WAIT_S):
        survey_folder.check_no_links(folder)
        recovered = recover(folder, asking_manifest=True)
        log, sealed = recovered.found, recovered.manifest
        if sealed is None or not is_sealed(recovered):
            raise AnalysisError(
                Message("the survey is not closed, or its manifest is damaged"), fault=CAN_RESUME
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
                ).reporting_only(errors.NOT_INTACT)
            )
        sealed.write_for(folder, log.records[-1])
        signer.sign(folder)
    say("the survey is signed as it is now")
    return DONE


INFO = Command(
    "Show what a survey contains, and what is missing or damaged in it.", _add_info, _info
)
VERIFY = Command(
    "Check a survey's folder: files, values, positions, signature. Without --repair nothing is "
    "changed; with it traces and recordings are not.",
    _add_verify,
    _verify,
)
SIGN = Command(
    "Sign a survey whose files are those of its manifest, with all that was added to its log. "
    "Whoever signs vouches for it: look at what was added with gpr20 info and gpr20 verify.",
    _add_sign,
    _sign,
)
