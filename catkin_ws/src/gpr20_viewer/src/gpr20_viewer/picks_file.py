"""The file of picks beside a survey, and which survey it is of."""

from __future__ import annotations

import csv
import hashlib
import io
import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.dataset import FREQUENCY, POLARIZATION, S21, S21_DIMS, X, Y, require
from gpr20_analysis.errors import PICKS_CHANGED, AnalysisError
from gpr20_analysis.formats.dataset_files import csv_cell
from gpr20_common.faults import NOT_ALLOWED
from gpr20_common.message import Message
from gpr20_common.mid.codec import plain, record_from
from gpr20_survey.files.durable_files import replace_file, sync_path, write_new_file
from gpr20_survey.folder import survey_folder
from gpr20_survey.folder.manifest import MANIFEST_FILE
from gpr20_viewer.picks import NO_CLEARANCE_BY_PICKS, Pick, PickEditor, Picks

FORMAT = "gpr20-picks/1"
SUFFIX = ".picks.json"


@dataclass(frozen=True)
class SurveyIdentity:
    """Which survey picks belong to.

    Attributes:
        survey_id: Identifier of the survey; empty if the data have none.
        survey_sha256: Of the positions and spectra that were loaded.
        simulated: Whether the survey was made by the simulated robot.
    """

    survey_id: str
    survey_sha256: str
    simulated: bool

    @staticmethod
    def of(survey: xr.Dataset) -> SurveyIdentity:
        """Return the identity of a survey that is in memory."""
        digest = hashlib.sha256()
        for name in (POLARIZATION, Y, X, FREQUENCY):
            digest.update(np.ascontiguousarray(survey[name].values, dtype="<f8").tobytes())
        for values in require(survey, S21, S21_DIMS).values:
            digest.update(np.ascontiguousarray(values, dtype="<c16").data)
        return SurveyIdentity(
            str(survey.attrs.get("survey_id", "")),
            digest.hexdigest(),
            bool(survey.attrs.get("simulated")),
        )


@dataclass(frozen=True)
class StoredPicks(SurveyIdentity):
    """The content of the file."""

    format: str
    notice: str
    next_number: int
    picks: Picks


class PicksFileError(AnalysisError, ValueError):
    """A file of picks cannot be used for this survey."""

    fault = NOT_ALLOWED


def picks_path(survey: Path) -> Path:
    """Return the file beside a survey, never inside its folder, which is sealed."""
    whole = sealed_folder(survey) or survey.expanduser().resolve()
    return whole.with_name(f"{whole.name}{SUFFIX}")


def sealed_folder(path: Path) -> Optional[Path]:
    """Return the outermost folder of a survey that is or contains a path; None: there is none."""
    found = path.expanduser().resolve()
    return next(filter(_is_survey, reversed([found, *found.parents])), None)


def _is_survey(folder: Path) -> bool:
    names = [*survey_folder.LOG_FILES, survey_folder.SURVEY_FILE, MANIFEST_FILE]
    # A recording alone may have been copied anywhere.
    if (folder / survey_folder.TRACES_FOLDER).is_dir():
        names += [survey_folder.BAG_FILE, survey_folder.MCAP_FILE]
    return any((folder / name).exists() for name in names)


class PicksFile:
    """Keeps the picks of one survey in a file.

    Args:
        path: The file.
        identity: The survey.

    Raises:
        PicksFileError: The file would be inside a survey's folder.
    """

    def __init__(self, path: Path, identity: SurveyIdentity) -> None:
        self.path = path.expanduser().resolve()
        self._identity = identity
        self._known: Optional[bytes] = None
        inside = sealed_folder(self.path.parent)
        if inside is not None:
            raise PicksFileError(
                Message(
                    "{path} is inside the survey {folder}, which is evidence and stays as it is; "
                    "choose another place with --picks",
                    path=self.path,
                    folder=inside,
                )
            )

    def load(self) -> Tuple[PickEditor, List[Message]]:
        """Return the stored picks, and notes on them; no picks if there is no file.

        Raises:
            PicksFileError: The file is damaged or belongs to another survey.
            OSError: It cannot be read.
        """
        self._known = self._content()
        if self._known is None:
            return PickEditor(), []
        try:
            stored = record_from(StoredPicks, json.loads(self._known.decode("utf-8")), "")
            if stored.format != FORMAT:
                raise ValueError(f"format {stored.format}")
            if len({one.id for one in stored.picks}) != len(stored.picks):
                raise ValueError("two picks of one name")
        except (ValueError, RecursionError) as error:
            raise PicksFileError(
                Message(
                    "{path} is damaged or no file of picks; move it away, or choose another file "
                    "with --picks",
                    path=self.path,
                    details=error,
                )
            ) from error
        return PickEditor(stored.picks, stored.next_number), self._compare(stored)

    def save(self, editor: PickEditor) -> None:
        """Write the picks; return when they are durable.

        Raises:
            PicksFileError: Another program has changed the file since it was read.
            OSError: It cannot be written; the former file is unchanged.
        """
        if self._content() != self._known:
            raise PicksFileError(
                Message(
                    "{path} was changed by another program, so the picks are not saved; export "
                    "them, then open the survey again",
                    path=self.path,
                ),
                fault=PICKS_CHANGED,
            )
        stored = StoredPicks(
            **asdict(self._identity),
            format=FORMAT,
            notice=str(NO_CLEARANCE_BY_PICKS),
            next_number=editor.next_number,
            picks=editor.picks,
        )
        text = json.dumps(plain(stored), indent=1, ensure_ascii=False, allow_nan=False)
        data = f"{text}\n".encode("utf-8", "replace")
        if self._known is None:
            write_new_file(self.path, data)
            sync_path(self.path.parent)
        else:
            replace_file(self.path, data)
        self._known = data

    def export(self, editor: PickEditor, path: Path) -> None:
        """Write the picks as CSV for other programs; the words do not depend on the language.

        Raises:
            PicksFileError: It would be inside a survey's folder, or replace the picks.
            ExportError: The file cannot be written.
        """
        inside = sealed_folder(path.expanduser().resolve().parent)
        if inside is not None or path.expanduser().resolve() == self.path:
            raise PicksFileError(
                Message("{path} is kept for the survey; export to another place", path=path)
            )
        shared = {
            **asdict(self._identity),
            "simulated": "SIMULATED" if self._identity.simulated else "",
            "notice": str(NO_CLEARANCE_BY_PICKS),
        }
        stream = io.StringIO()
        names = [*(field.name for field in fields(Pick)), *shared]
        writer = csv.DictWriter(stream, names, lineterminator="\n")
        writer.writeheader()
        for one in editor.picks:
            cells = {**asdict(one), **shared}
            writer.writerow({name: csv_cell(value) for name, value in cells.items()})
        with atomic_output(path) as place:
            place.write_text(stream.getvalue(), encoding="utf-8")

    def _content(self) -> Optional[bytes]:
        return self.path.read_bytes() if self.path.exists() else None

    def _compare(self, stored: StoredPicks) -> List[Message]:
        own = self._identity
        same_data = stored.survey_sha256 == own.survey_sha256
        if stored.survey_id != own.survey_id or not (stored.survey_id or same_data):
            raise PicksFileError(
                Message(
                    "{path} belongs to another survey ({other}, this one is {own}); choose "
                    "another file with --picks",
                    path=self.path,
                    other=stored.survey_id or stored.survey_sha256[:12],
                    own=own.survey_id or own.survey_sha256[:12],
                )
            )
        if same_data:
            return []
        return [
            Message(
                "the picks were made on other data of this survey, for example before it was "
                "continued or with other steps; check each of them"
            )
        ]
