"""Imported data as the folder of a survey, which the robot's programs read like its own.

Nothing of a plan is invented: survey.json has the entry `imported` in place of parameters and axes
(docs/reference/formats.md). What the source does not say is absent, or a decision in the log.
"""

from __future__ import annotations

import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, Mapping

import numpy as np
import xarray as xr

from gpr20_analysis import __version__, dataset, errors
from gpr20_analysis.atomic_output import atomic_output
from gpr20_analysis.dataset import HEIGHT, S21, S21_DIMS, SAMPLE_DIMS, TIMESTAMP
from gpr20_analysis.errors import ExportError
from gpr20_analysis.read import survey_attributes
from gpr20_analysis.sentences import DECISIONS, sentences_of
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message
from gpr20_common.terminal_text import printable
from gpr20_survey.errors import SurveyRefusedError, TraceRefusedError
from gpr20_survey.files import durable_files
from gpr20_survey.files.regular_files import FileSum, regular_files, sum_of, sum_of_file
from gpr20_survey.folder import manifest, survey_folder, survey_metadata, trace_files
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.survey_log import SurveyLog
from gpr20_survey.folder.survey_metadata import START
from gpr20_survey.plan.annotation import ANNOTATION, Annotation, Wgs84Position
from gpr20_survey.plan.recorded_plan import IMPORTED, TIMES_KNOWN, import_sentence, imported_grid
from gpr20_survey.recording.mcap_writer import McapFile
from gpr20_survey.recording.survey_topics import SurveyTopics
from gpr20_survey.trace import utc_time
from gpr20_survey.trace.sweep import AnalyzerSettings
from gpr20_survey.trace.trace import Trace

SOFTWARE = f"gpr20 {__version__}"
# Between the recorded messages of traces whose times are not known, so that a replay shows them
# one after the other [ns].
INTERVAL_NS = utc_time.NS_PER_S // 10
COMMIT_BYTES = 8 << 20
# Endings of files with one stem that are read together.
BELONG = (".dt1", ".hd", ".rd3", ".rd7", ".rad")
SOURCES_FILE = "imported.sha256"
"""The checksums of the files of the source, as sha256sum checks them in its folder."""
DECISION_FORMAT = "gpr20-import/1"
# What a folder holds of a Dataset; anything else would be lost.
VARIABLES = {S21, HEIGHT, TIMESTAMP, dataset.QUALITY, "remarks", "sample_id", "index"}


@dataclass(frozen=True)
class ImportSource:
    """What was imported.

    Attributes:
        name: Name of the file or folder.
        form: Name of its format.
        sums: Of each of its files, by its name.
    """

    name: str
    form: str
    sums: Mapping[str, FileSum]

    @property
    def size(self) -> int:
        """Size of the files together [bytes]."""
        return sum(one.size for one in self.sums.values())

    @property
    def sha256(self) -> str:
        """Of the file, or of the list of several."""
        first, *others = self.sums.values()
        return sum_of(self.listed()).sha256 if others else first.sha256

    def listed(self) -> bytes:
        """Return the content of SOURCES_FILE."""
        lines = []
        for name, found in sorted(self.sums.items()):
            safe = name.replace("\\", r"\\").replace("\n", r"\n")
            mark = "" if safe == name else "\\"  # as sha256sum writes it
            lines.append(f"{mark}{found.sha256}  {safe}\n")
        return "".join(lines).encode("utf-8", "surrogateescape")

    @classmethod
    def of(cls, path: Path, form: str) -> ImportSource:
        """Return a source whose files are read here.

        Raises:
            OSError: One of them cannot be read.
        """
        if path.is_dir():
            sums = {name: sum_of_file(path / name) for name in regular_files(path)}
        else:
            belong = {path.stem.lower() + ending for ending in BELONG}
            beside = [one for one in path.parent.iterdir() if one.name.lower() in belong]
            sums = {one.name: sum_of_file(one) for one in (path, *beside)}
        return cls(printable(path.name), form, sums)


def write_imported_folder(
    survey: xr.Dataset, data: Path, source: ImportSource, progress: Progress = no_progress
) -> Path:
    """Write spectra as a survey's folder in the folder of the surveys.

    It gets its name when all of it is on the disk: nothing lists an import that was cut off.

    Args:
        survey: Dataset of the import.
        data: The folder of the surveys; made if it is missing.
        source: What was imported.
        progress: Shows the progress.

    Returns:
        The survey's folder, with the name that the robot gives its own.

    Raises:
        ExportError: A survey's folder cannot hold the data, or it cannot be written.
    """
    try:
        content = _Content(survey, source)
        folder = survey_folder.survey_folder(data, content.survey_id, content.started_us)
        # Each trace as numbers in JSON, twice: its file and its messages.
        with atomic_output(folder, 5 * int(survey[S21].nbytes)) as place:
            # That of a temporary folder would let nobody else read the survey.
            durable_files.make_new_folder(place, data.stat().st_mode & durable_files.FOLDER_MODES)
            content.write(place, folder.name, progress)
        durable_files.sync_path(data)
    except (InvalidValueError, SurveyRefusedError, TraceRefusedError) as error:
        raise ExportError(
            Message(
                "a survey's folder cannot hold the data: {reason}; write a .nc",
                reason=error.message,
            ),
            fault=errors.INPUT,
        ) from error
    return folder


class _Content:
    """What a survey's folder holds of imported data."""

    def __init__(self, survey: xr.Dataset, source: ImportSource) -> None:
        others = sorted(map(str, set(survey.data_vars) - VARIABLES))
        if others or S21 not in survey:
            raise InvalidValueError(Message("they contain {names}", names=", ".join(others)))
        survey = survey.sortby(list(SAMPLE_DIMS)).transpose(*SAMPLE_DIMS, ...)
        self._survey, self._source = survey, source
        self._usable = dataset.usable(survey).values
        if not self._usable.any():
            raise InvalidValueError(Message("there is no sample with data"))
        self._s21 = dataset.require(survey, S21, S21_DIMS).values
        self.survey_id, self._now_us = str(uuid.uuid4()), time.time_ns() // utc_time.NS_PER_US
        self._times_us = survey[TIMESTAMP].values.astype("datetime64[us]").astype(np.int64)
        own_us = self._times_us[self._usable].tolist()
        self._are_times_known = all(map(utc_time.is_plausible, own_us))
        if not self._are_times_known:
            self._times_us = np.full(self._usable.shape, self._now_us)
            own_us = [self._now_us]
        self.started_us, self._ended_us = min(own_us), max(own_us)
        self._description = self._described()
        self._grid = imported_grid(self._description)

    def write(self, folder: Path, name: str, progress: Progress) -> None:
        """Write all files into a new folder; return when they are on the disk.

        Args:
            folder: The folder.
            name: Its name when it is complete.
            progress: Shows the progress.
        """
        log = SurveyLog(folder, [], whole=False)
        log.take(log.next(Kind.PLAN, self._description, self._description["started"]))
        reason, now = import_sentence(self._description), utc_time.iso_text(self._now_us)
        sums = self._write_traces(folder, name, log, progress)
        for one in sentences_of(self._survey, DECISIONS):
            message = survey_metadata.message_record(one)
            values = {"format": DECISION_FORMAT, "text": str(one), "message": message}
            log.take(log.next(Kind.DECISION, values, now))
        ending = {
            "ended": utc_time.iso_text(self._ended_us),
            "outcome": IMPORTED,
            "reason": str(reason),
            survey_metadata.REASON_MESSAGE: survey_metadata.message_record(reason),
            survey_metadata.FAULT_CODE: "",
            "stored_traces": int(self._usable.sum()),
            manifest.CONTENT: manifest.content_sum(sums),
        }
        log.take(log.next(Kind.END, ending, now))
        log.write()
        durable_files.write_in_new_folder(folder / SOURCES_FILE, self._source.listed())
        log.write_description()
        manifest.write_manifest(folder, self.survey_id, log.last, SOFTWARE, now, sums)

    def _write_traces(
        self, folder: Path, name: str, log: SurveyLog, progress: Progress
    ) -> Dict[str, FileSum]:
        """Write the traces and their recording; return the checksums of the files."""
        sums: Dict[str, FileSum] = {}
        topics = SurveyTopics()
        text = survey_metadata.encode(self._description).decode("ascii")
        time_ns = self.started_us * utc_time.NS_PER_US
        traces = folder / survey_folder.TRACES_FOLDER
        durable_files.ensure_folder(traces)
        recording = McapFile(folder / survey_folder.MCAP_FILE)
        try:
            recording.write(topics.replay(self._description, Path(name), time_ns))
            recording.write(topics.metadata(text, time_ns))
            recording.write(topics.log(log.last, time_ns))
            for trace in progress(self._traces(), int(self._usable.sum())):
                file, content = survey_folder.trace_file_name(trace), trace_files.encode(trace)
                durable_files.write_in_new_folder(traces / file, content)
                sums[manifest.trace_name(file)] = sum_of(content)
                own_ns = trace.timestamp_us * utc_time.NS_PER_US
                time_ns = own_ns if self._are_times_known else time_ns + INTERVAL_NS
                recording.write_alone(topics.trace(trace, time_ns))
                if recording.collected_bytes > COMMIT_BYTES:
                    recording.commit()
            recording.finish()
        finally:
            recording.abandon()
        durable_files.sync_path(traces)
        sums[survey_folder.MCAP_FILE] = sum_of_file(folder / survey_folder.MCAP_FILE)
        return sums

    def _traces(self) -> Iterator[Trace]:
        """Yield the traces in order of time."""
        axes = (self._grid.polarization_deg, self._grid.y_mm, self._grid.x_mm)
        turns, rows, columns = ({one: place for place, one in enumerate(axis)} for axis in axes)
        placed = [
            ((turns[one.z_deg], rows[one.y_mm], columns[one.x_mm]), one)
            for one in self._grid.points()
        ]
        placed.sort(key=lambda one: int(self._times_us[one[0]]))
        for place, point in placed:
            if self._usable[place]:
                time_us = int(self._times_us[place])
                yield Trace(
                    frequency_hz=self._survey[dataset.FREQUENCY].values.astype(np.float64),
                    s21_real=self._s21[place].real.astype(np.float64),
                    s21_imag=self._s21[place].imag.astype(np.float64),
                    sweep_started_us=time_us,
                    sweep_ended_us=time_us,
                    quality=(),
                    analyzer=AnalyzerSettings(),
                    survey_id=self.survey_id,
                    sample_id=f"{self.survey_id}-{point.index}",
                    index=point.index,
                    timestamp_us=time_us,
                    x_coord_mm=point.x_mm,
                    y_coord_mm=point.y_mm,
                    z_coord_deg=point.z_deg,
                    antennae_height_m=float(self._survey[HEIGHT].values[place]),
                )

    def _described(self) -> Dict[str, Any]:
        """Return survey.json as it is before the end."""
        attributes, source = self._survey.attrs, self._source
        entry: Dict[str, Any] = {
            "source": source.name,
            "format": source.form,
            "files": len(source.sums),
            "sha256": source.sha256,
            "size": source.size,
            "time": utc_time.iso_text(self._now_us),
            "software": SOFTWARE,
            TIMES_KNOWN: self._are_times_known,
            **survey_attributes.imported_entry(self._survey),
            DECISIONS: list(map(str, sentences_of(self._survey, DECISIONS))),
        }
        description: Dict[str, Any] = {
            "format": survey_metadata.FORMAT,
            "survey_id": self.survey_id,
            "started": utc_time.iso_text(self.started_us),
            **START,
            IMPORTED: entry,
            ANNOTATION: _annotation(attributes).values(),
        }
        if dataset.SIMULATED in attributes:
            description[dataset.SIMULATED] = bool(attributes[dataset.SIMULATED])
        text = survey_metadata.encode(description).decode("ascii")
        survey_metadata.parse_object(text, survey_folder.SURVEY_FILE)
        return description


def _annotation(attributes: Dict[str, Any]) -> Annotation:
    names = survey_attributes
    place = [attributes.get(one) for one in (names.LATITUDE, names.LONGITUDE)]
    return Annotation(
        operator=str(attributes.get(names.OPERATOR, "")),
        site=str(attributes.get(names.SITE, "")),
        notes=str(attributes.get(names.NOTES, "")),
        position=None if None in place else Wgs84Position(*map(float, place)),  # type: ignore[arg-type]
        name=str(attributes.get(names.NAME, "")),
    )
