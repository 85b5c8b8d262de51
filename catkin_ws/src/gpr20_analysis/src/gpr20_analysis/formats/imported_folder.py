"""Imported data as the folder of a survey, which the robot's programs read like its own.

Nothing of a plan is invented: survey.json has the entry `imported` in place of parameters and axes
(docs/formats.md). What the source does not say is absent.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import time
import uuid
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple

import numpy as np
import xarray as xr

from gpr20_analysis import __version__, dataset, faults
from gpr20_analysis.dataset import HEIGHT, S21, S21_DIMS, SAMPLE_DIMS, TIMESTAMP
from gpr20_analysis.errors import ExportError
from gpr20_analysis.progress import Progress, no_progress
from gpr20_analysis.read import analyzer_attributes, annotation_attributes
from gpr20_analysis.read.antenna_attributes import ANTENNA_DELAY, S_PER_NS
from gpr20_analysis.sentences import FAULTS, MESSAGES, MISSING, recorded_templates
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.os_reason import os_reason
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.files import durable_files
from gpr20_survey.files.file_sums import FileSum, regular_files, sum_of, sum_of_file
from gpr20_survey.files.folder_lock import locked, writer_of
from gpr20_survey.folder import manifest, sealing, survey_folder, survey_metadata
from gpr20_survey.folder.log_content import START
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.plan.annotation import ANNOTATION, Annotation, Wgs84Position
from gpr20_survey.plan.antenna_delay import KEY, SECTION, recorded_delay_ns
from gpr20_survey.plan.imported import (
    GRID,
    IMPORTED,
    TIMES_KNOWN,
    ImportedGrid,
    import_sentence,
    imported_grid,
)
from gpr20_survey.recording.recordings import new_mcap
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.trace import trace_json, utc_time
from gpr20_survey.trace.sweep import storable_remark
from gpr20_survey.trace.sweep_settings import AnalyzerSettings
from gpr20_survey.trace.trace import SAMPLE_ID, Trace
from gpr20_survey.trace.trace_definition import TRACE_DEFINITION

# Between the recorded messages of traces whose times are not known, so that a replay shows them
# one after the other [ns].
INTERVAL_NS = utc_time.NS_PER_S // 10
COMMIT_BYTES = 8 << 20
# What a folder holds of a Dataset; anything else would be lost.
VARIABLES = {S21, HEIGHT, TIMESTAMP, dataset.QUALITY, "remarks", "sample_id", "index"}
# Attributes that the folder holds elsewhere, or that its reader makes.
ELSEWHERE = {
    *("format", "source", "survey_id", "simulated", "stored", "planned", "survey_json"),
    *(MISSING, FAULTS, MESSAGES, *annotation_attributes.ATTRIBUTES),
    *analyzer_attributes.ATTRIBUTES,
}


@dataclass(frozen=True)
class ImportSource:
    """What was imported.

    Attributes:
        name: Name of the file or folder.
        form: Name of its format.
        files: Number of its files.
        content: Checksum of the file, or of the list of a folder's files, and their size.
    """

    name: str
    form: str
    files: int
    content: FileSum

    @classmethod
    def of(cls, path: Path, form: str) -> ImportSource:
        """Return a source whose files are read here.

        Raises:
            OSError: One of them cannot be read.
        """
        if not path.is_dir():
            return cls(path.name, form, 1, sum_of_file(path))
        sums = {name: sum_of_file(path / name) for name in regular_files(path)}
        size = sum(one.size for one in sums.values())
        return cls(path.name, form, len(sums), FileSum(sealing.content_sum(sums), size))


def write_imported_folder(
    survey: xr.Dataset, data: Path, source: ImportSource, progress: Progress = no_progress
) -> Path:
    """Write spectra as a survey's folder in the folder of the surveys.

    It gets its name when all of it is on the disk: nothing lists an import that was cut off.

    Args:
        survey: Dataset of the import.
        data: The folder of the surveys; made if it is missing, but not the one above it.
        source: What was imported.
        progress: Shows the progress.

    Returns:
        The survey's folder, with the name that the robot gives its own.

    Raises:
        ExportError: A survey's folder cannot hold the data, or it cannot be written.
        InvalidValueError: The name, notes or place of the survey are not allowed.
    """
    try:
        with _refusing():
            content = _Content(survey, source, time.time_ns() // utc_time.NS_PER_US)
        durable_files.ensure_folder(data)
        _remove_abandoned(data)
        folder = data / content.name
        place = durable_files.temporary_path(folder)
        durable_files.make_new_folder(place)
        try:
            with _refusing(), locked(place):
                content.write(place, progress)
                os.rename(str(place), str(folder))
            durable_files.sync_path(data)
        finally:
            shutil.rmtree(str(place), ignore_errors=True)
    except OSError as error:
        raise ExportError(
            Message(
                "{path} cannot be written: {reason}; check free space and permissions of "
                "{folder}, or choose another place",
                path=data,
                reason=os_reason(error),
                folder=data.absolute().parent,
            )
        ) from error
    return folder


def _remove_abandoned(data: Path) -> None:
    """Remove what imports that were killed have left; one that still runs holds its lock."""
    for one in data.iterdir():
        is_ours = durable_files.is_temporary(one.name) and survey_folder.FOLDER_NAME.match(
            one.name[len(durable_files.TEMPORARY_PREFIX) :]
        )
        if is_ours and one.is_dir() and not one.is_symlink() and writer_of(one) is None:
            shutil.rmtree(str(one))


@contextlib.contextmanager
def _refusing() -> Iterator[None]:
    """Say of what a survey cannot hold that another output can."""
    try:
        yield
    except (TraceRefusedError, SurveyRefusedError) as error:
        raise _refused(error.message) from error


def _refused(reason: Message) -> ExportError:
    return ExportError(
        Message("a survey's folder cannot hold the data: {reason}; write a .nc", reason=reason),
        fault=faults.FORMAT,
    )


class _Content:
    """What a survey's folder holds of imported data."""

    def __init__(self, survey: xr.Dataset, source: ImportSource, now_us: int) -> None:
        survey = survey.sortby(list(SAMPLE_DIMS)).transpose(*SAMPLE_DIMS, ...)
        others = sorted(map(str, set(survey.data_vars) - VARIABLES))
        if S21 not in survey or others:
            names = ", ".join(others) or dataset.A_SCAN
            raise _refused(Message("they contain {names}", names=names))
        self._survey = survey
        self._usable = dataset.usable(survey).values
        if not self._usable.any():
            raise _refused(Message("there is no sample with data"))
        self._s21 = dataset.require(survey, S21, S21_DIMS).values
        self._survey_id = str(uuid.uuid4())
        own = Counter(map(str, survey["sample_id"].values.flat)) if "sample_id" in survey else {}
        self._ids = {one for one, count in own.items() if count == 1 and SAMPLE_ID.fullmatch(one)}
        self._times_us = self._known_times_us()
        known = self._times_us is not None
        times_us = self._times_us[self._usable] if known else [now_us]  # type: ignore[index]
        self._started_us, self._ended_us = int(min(times_us)), int(max(times_us))
        self._now_us = now_us
        self._description = self._described(source)
        self.name = survey_folder.survey_folder(Path(), self._survey_id, self._started_us).name

    def write(self, folder: Path, progress: Progress) -> None:
        """Write all files into a new folder; return when they are on the disk."""
        durable_files.ensure_folder(folder / survey_folder.TRACES_FOLDER)
        log = SurveyLog(folder, [], whole=False)
        log.take(log.next(Kind.PLAN, self._description, self._description["started"]))
        sums = self._write_traces(folder, log, progress)
        reason = import_sentence(self._description)
        ending = {
            "ended": utc_time.iso_text(self._ended_us),
            "outcome": IMPORTED,
            "reason": str(reason),
            survey_metadata.REASON_MESSAGE: survey_metadata.message_record(reason),
            survey_metadata.FAULT_CODE: "",
            "stored_traces": int(self._usable.sum()),
            sealing.CONTENT: sealing.content_sum(sums),
        }
        now = utc_time.iso_text(self._now_us)
        log.take(log.next(Kind.END, ending, now))
        log.write()
        sealing.write_manifest(folder, log, _SOFTWARE, now, sums)

    def _write_traces(self, folder: Path, log: SurveyLog, progress: Progress) -> Dict[str, FileSum]:
        sums: Dict[str, FileSum] = {}
        topics = SurveyTopics(TRACE_DEFINITION)
        text = survey_metadata.encode(self._description).decode("ascii")
        time_ns = self._started_us * utc_time.NS_PER_US
        recording = new_mcap(folder / survey_folder.MCAP_FILE, self._description)
        try:
            recording.write(topics.replay(self._description, Path(self.name), time_ns))
            recording.write(topics.metadata(text, time_ns))
            recording.write(topics.log(log.last, time_ns))
            places = self._places()
            for index, place in progress(places, len(places)):
                trace = self._trace(index, place)
                name = manifest.trace_name(survey_folder.trace_file_name(trace))
                content = trace_json.encode(trace)
                durable_files.write_in_new_folder(folder / name, content)
                sums[name] = sum_of(content)
                if self._times_us is None:
                    time_ns += INTERVAL_NS
                else:
                    time_ns = trace.timestamp_us * utc_time.NS_PER_US
                recording.write_alone(topics.trace(trace, time_ns))
                if recording.collected_bytes > COMMIT_BYTES:
                    recording.commit()
            recording.finish()
        finally:
            recording.abandon()
        durable_files.sync_path(folder / survey_folder.TRACES_FOLDER)
        sums[survey_folder.MCAP_FILE] = sum_of_file(folder / survey_folder.MCAP_FILE)
        return sums

    def _places(self) -> List[Tuple[int, Tuple[int, ...]]]:
        """Return index and place in the arrays of each trace, in order of time."""
        grid = imported_grid(self._description)
        axes = (grid.polarization_deg, grid.y_mm, grid.x_mm)
        numbers = [{value: number for number, value in enumerate(axis)} for axis in axes]
        found: List[Tuple[int, Tuple[int, ...]]] = [
            (one.index, (numbers[0][one.z_deg], numbers[1][one.y_mm], numbers[2][one.x_mm]))
            for one in grid.points()
        ]
        times_us = self._times_us
        found = [(index, place) for index, place in found if self._usable[place]]
        if times_us is not None:
            found.sort(key=lambda one: int(times_us[one[1]]))
        return found

    def _trace(self, index: int, place: Tuple[int, ...]) -> Trace:
        survey, grid = self._survey, self._description[IMPORTED][GRID]
        time_us = self._started_us if self._times_us is None else int(self._times_us[place])
        own_id = str(survey["sample_id"].values[place]) if "sample_id" in survey else ""
        remarks = str(survey["remarks"].values[place]) if "remarks" in survey else ""
        values = self._s21[place]
        turn, row, column = place
        return Trace(
            frequency_hz=survey[dataset.FREQUENCY].values.astype(np.float64),
            s21_real=values.real.astype(np.float64),
            s21_imag=values.imag.astype(np.float64),
            sweep_started_us=time_us,
            sweep_ended_us=time_us,
            quality=tuple(storable_remark(one) for one in remarks.split("; ") if one),
            analyzer=self._analyzer,
            survey_id=self._survey_id,
            sample_id=own_id if own_id in self._ids else f"{self._survey_id}-{index}",
            index=index,
            timestamp_us=time_us,
            x_coord_mm=grid["x_mm"][column],
            y_coord_mm=grid["y_mm"][row],
            z_coord_deg=grid["polarization_deg"][turn],
            antennae_height_m=float(survey[HEIGHT].values[place]),
        )

    @property
    def _analyzer(self) -> AnalyzerSettings:
        found = self._survey.attrs
        return AnalyzerSettings(
            float(found.get(analyzer_attributes.IF_BANDWIDTH, 0.0)),
            int(found.get(analyzer_attributes.AVERAGES, 0)),
            str(found.get(analyzer_attributes.OUTPUT_POWER, "")),
        )

    def _known_times_us(self) -> Optional[np.ndarray]:
        """Return when each sample was measured [us since 1970]; None unless all are known."""
        if TIMESTAMP not in self._survey:
            return None
        stamps = self._survey[TIMESTAMP].values
        times_us: np.ndarray = stamps.astype("datetime64[us]").astype(np.int64)
        own = times_us[self._usable]
        known = all(map(utc_time.is_plausible, (int(own.min()), int(own.max()))))
        return times_us if known else None

    def _described(self, source: ImportSource) -> Dict[str, Any]:
        """Return survey.json as it is before the end."""
        attributes = self._survey.attrs
        turns_deg, y_m, x_m = (self._survey[axis].values.astype(np.float64) for axis in SAMPLE_DIMS)
        grid = ImportedGrid(
            tuple(turns_deg.tolist()),
            *(tuple(_in_mm(one).tolist()) for one in (y_m, x_m)),
        )
        entry: Dict[str, Any] = {
            "source": source.name,
            "format": source.form,
            "files": source.files,
            "sha256": source.content.sha256,
            "size": source.content.size,
            "time": utc_time.iso_text(self._now_us),
            "software": _SOFTWARE,
            TIMES_KNOWN: self._times_us is not None,
            GRID: {name: list(axis) for name, axis in vars(grid).items()},
            "attributes": _kept(attributes),
        }
        if attributes.get("survey_id"):
            entry["survey_id"] = str(attributes["survey_id"])
        description: Dict[str, Any] = {
            "format": survey_metadata.FORMAT,
            "survey_id": self._survey_id,
            "started": utc_time.iso_text(self._started_us),
            **START,
            "software_revision": _SOFTWARE,
            IMPORTED: entry,
            ANNOTATION: _annotation(attributes).values(),
        }
        if "simulated" in attributes:
            description["simulated"] = bool(attributes["simulated"])
        delay = {SECTION: {KEY: float(attributes.get(ANTENNA_DELAY, 0.0)) / S_PER_NS}}
        with contextlib.suppress(InvalidValueError):  # beyond what the robot may have
            recorded_delay_ns(delay)
            description.update(delay)
        text = survey_metadata.encode(description).decode("ascii")
        survey_metadata.parse_object(text, survey_folder.SURVEY_FILE)
        try:
            imported_grid(description)
        except InvalidValueError as error:
            raise _refused(error.message) from error
        return description


def _in_mm(place_m: np.ndarray) -> np.ndarray:
    """Return positions [mm] that give the same ones in metres again, where there are such."""
    place_mm = place_m * dataset.MM_PER_M
    short = np.round(place_mm, 9)
    return np.where(short / dataset.MM_PER_M == place_m, short, place_mm)


_SOFTWARE = f"gpr20 {__version__}"


def _kept(attributes: Dict[str, Any]) -> Dict[str, Any]:
    """Return the attributes that have no place of their own, as values of JSON."""
    found: Dict[str, Any] = {}
    for name, value in attributes.items():
        if name in ELSEWHERE:
            continue
        found[name] = value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
    texts = {
        str(one)
        for value in found.values()
        for one in (value if isinstance(value, (list, tuple)) else [value])
    }
    templates = recorded_templates(attributes)
    found[MESSAGES] = json.dumps({text: templates[text] for text in texts if text in templates})
    return found


def _annotation(attributes: Dict[str, Any]) -> Annotation:
    names = annotation_attributes
    place = [attributes.get(one) for one in (names.LATITUDE, names.LONGITUDE)]
    heading = attributes.get(names.HEADING)
    return Annotation(
        name=str(attributes.get(names.NAME, "")),
        operator=str(attributes.get(names.OPERATOR, "")),
        site=str(attributes.get(names.SITE, "")),
        notes=str(attributes.get(names.NOTES, "")),
        position=None if None in place else Wgs84Position(*map(float, place)),  # type: ignore[arg-type]
        heading_deg=None if heading is None else float(heading),
    )
