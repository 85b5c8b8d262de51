"""The report of a survey: its sections in the order in which an officer asks."""

from __future__ import annotations

import datetime
import platform
from importlib import metadata
from pathlib import Path
from typing import Callable, List, Optional, Sequence, Union

import numpy as np
import xarray as xr

from gpr20_analysis import __version__, dataset
from gpr20_analysis.candidates.answer import Answer
from gpr20_analysis.candidates.markers import marker_heading, marker_rows, survey_markers
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.permittivity import permittivity_line
from gpr20_analysis.plotting import maps
from gpr20_analysis.processing.chain import Step
from gpr20_analysis.read.survey_attributes import NAME, SITE
from gpr20_analysis.read.verdict import Verification
from gpr20_analysis.read.verification import FILES, verify_survey
from gpr20_analysis.report import places
from gpr20_analysis.report.drift import HEADING, drift_lines, drift_rows
from gpr20_analysis.report.page import Report, Section, check_report_path, save_report
from gpr20_analysis.report.summary import SIMULATED, Row, settings_of, summary_of, warnings_of
from gpr20_analysis.sentences import (
    DECISIONS,
    DOUBTS,
    NOTES,
    labelled,
    limited,
    sentences_of,
    shown,
)
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.catalogue import Catalogue, Language, language_from_code, read_catalogue
from gpr20_common.message import Message, numeral, verbatim
from gpr20_survey.results.candidates import NO_CLEARANCE
from gpr20_survey.results.hiding_map import HidingMap
from gpr20_survey.trace.utc_time import moment_text

LISTED = 50
"""Number of sentences of a list that the report shows."""
LIBRARIES = ("numpy", "scipy", "xarray", "h5py", "matplotlib", "rosbags", "mcap")


def write_report(
    survey: xr.Dataset,
    path: Union[str, Path],
    output: Union[str, Path],
    options: Optional[ImageOptions] = None,
    steps: Sequence[Step] = (),
    language: str = Language.ENGLISH.value,
    progress: Progress = no_progress,
    hiding: Optional[HidingMap] = None,
) -> None:
    """Write a report as one HTML file.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        output: The file: .html.
        options: How the image is made.
        steps: The steps before imaging; without any, coupling and surface echo are subtracted.
        language: Code of the language.
        progress: Shows the progress.
        hiding: Where a mine could hide; None: the report has no such map.

    Raises:
        AnalysisError: The file has another ending or cannot be written.
    """
    check_report_path(Path(output))
    known = language_from_code(language)
    catalogue = read_catalogue(known)
    simulated = bool(survey.attrs.get("simulated"))
    made = Report(
        title=title_of(survey, catalogue),
        sections=sections_of(
            survey, Path(path), steps, options or ImageOptions(), progress, catalogue, hiding
        ),
        language=known,
        mark=catalogue.tr("SIMULATED") if simulated else "",
        banner=catalogue.text(SIMULATED) if simulated else "",
        footer=catalogue.text(NO_CLEARANCE),
    )
    save_report(made, Path(output))


def title_of(survey: xr.Dataset, catalogue: Catalogue) -> str:
    """Return name, site and date of a survey; its id, or its source, only without these."""
    known = survey.attrs
    names = [str(known[name]) for name in (NAME, SITE) if known.get(name)]
    names = names or [str(known.get("survey_id") or known.get("source") or "")]
    parts = [catalogue.tr("GPR-20 survey {name}", name=", ".join(names))]
    return ", ".join(filter(None, [*parts, str(known.get("started", ""))[:10]]))


def sections_of(
    survey: xr.Dataset,
    path: Path,
    steps: Sequence[Step],
    options: ImageOptions,
    progress: Progress,
    catalogue: Catalogue,
    hiding: Optional[HidingMap] = None,
) -> List[Section]:
    """Return the sections of a survey's report: what to check, what was missed, what to believe.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        steps: The steps before imaging.
        options: How the image is made.
        progress: Shows the progress.
        catalogue: Language of the report.
        hiding: Where a mine could hide; None: there is no such map.
    """
    found, error = places.answered(survey, steps, options)
    believed, *verification = _believed(survey, path, found, catalogue)
    parts: List[Callable[[], Section]] = [
        lambda: places.places_section(found, error, options, catalogue),
        lambda: places.missed_section(survey, hiding, catalogue),
        lambda: believed,
    ]
    if found is not None:
        image = found
        parts += [
            lambda: places.image_section(image, options, catalogue),
            lambda: places.processed_section(image, steps, options, catalogue),
        ]
    parts += [
        lambda: _markers(survey, catalogue),
        lambda: _quality(survey, catalogue),
        lambda: places.measured_section(survey, options, catalogue),
        lambda: _table(Message("Survey"), summary_of(survey), catalogue),
        lambda: _table(Message("Measurement settings"), settings_of(survey), catalogue),
        lambda: _drift(survey, catalogue),
        lambda: _sensors(survey, catalogue),
        *[lambda one=one: one for one in verification],
        lambda: _table(Message("Software versions"), versions(survey), catalogue),
    ]
    made = [part() for part in progress(parts, len(parts))]
    return [one for one in made if not one.empty]


def versions(survey: xr.Dataset) -> List[Row]:
    """Return the versions of the software that measured the survey and made the report."""
    now = datetime.datetime.now(datetime.timezone.utc)
    recorded = survey.attrs.get("software_revision")
    robot = Message("not recorded") if recorded is None else verbatim(str(recorded))
    libraries = {
        "gpr20_analysis": __version__,
        "Python": platform.python_version(),
        **{name: metadata.version(name) for name in LIBRARIES},
    }
    return [
        (Message("report created"), moment_text(now.isoformat(timespec="seconds"))),
        (Message("software of the robot"), robot),
        *((verbatim(name), verbatim(version)) for name, version in libraries.items()),
    ]


def _table(title: Message, rows: Sequence[Row], catalogue: Catalogue) -> Section:
    texts = [tuple(shown(one, catalogue) for one in row) for row in rows]
    return Section(catalogue.text(title), rows=texts)


def _believed(
    survey: xr.Dataset, path: Path, found: Optional[Answer], catalogue: Catalogue
) -> List[Section]:
    """Return how far the data can be believed, and the verification."""
    warnings = [SIMULATED] if survey.attrs.get("simulated") else []
    good: List[Message] = []
    checked: Optional[Verification] = None
    if path.is_dir() and any((path / name).exists() for name in FILES):
        checked = verify_survey(path)
        (warnings if checked.status else good).append(checked.verdict)
    else:
        good.append(
            Message("Only the folder of a survey can be verified against its plan and checksums.")
        )
    warnings += [*sentences_of(survey, DOUBTS), *limited(warnings_of(survey), LISTED)]
    if found is not None:
        # What the image says beyond the survey, such as how it was assumed to be.
        said = {str(one) for one in (*warnings, *sentences_of(survey, NOTES))}
        notes = [one for one in found.found.notes if str(one) not in said]
        good += [permittivity_line(found.image), *notes]
    title = Message("How far the data can be believed")
    sections = [_section(title, warnings, good, catalogue)]
    if checked is not None:
        faults = limited(checked.faults, LISTED)
        sections.append(_section(Message("Verification"), faults, checked.notes, catalogue))
    return sections


def _markers(survey: xr.Dataset, catalogue: Catalogue) -> Section:
    title = catalogue.tr("Markers")
    try:
        found = survey_markers(survey)
    except AnalysisError as error:
        return Section(title, warnings=[shown(error.message, catalogue)])
    rows = marker_rows(found, catalogue)
    return Section(title, rows=rows, heading=marker_heading(catalogue) if rows else ())


def _sensors(survey: xr.Dataset, catalogue: Catalogue) -> Section:
    """Return what other sensors measured: number of values, lowest, median, highest."""
    rows = []
    for name in dataset.aux_names(survey):
        values = survey[name].values[np.isfinite(survey[name].values)]
        if values.size:
            found = np.percentile(values, [0.0, 50.0, 100.0])
            figures = [catalogue.text(numeral(one, ".6g")) for one in found]
            unit = str(survey[name].attrs.get("units", ""))
            rows.append(
                (name[len(dataset.AUX_PREFIX) :], unit, f"{values.size}/{survey[name].size}")
                + tuple(figures)
            )
    heading = (
        catalogue.tr("sensor"),
        catalogue.tr("unit"),
        catalogue.tr("samples"),
        catalogue.tr("lowest"),
        catalogue.tr("median"),
        catalogue.tr("highest"),
    )
    return Section(catalogue.tr("Other sensors"), rows=rows, heading=heading if rows else ())


def _drift(survey: xr.Dataset, catalogue: Catalogue) -> Section:
    """Return what measuring the first stop again showed."""
    title = Message("Drift and repeatability")
    section = _section(title, [], drift_lines(survey), catalogue)
    section.rows = [tuple(map(catalogue.text, row)) for row in drift_rows(survey)]
    section.heading = tuple(catalogue.text(one) for one in HEADING) if section.rows else ()
    return section


def _section(
    title: Message, warnings: Sequence[Message], lines: Sequence[Message], catalogue: Catalogue
) -> Section:
    return Section(
        catalogue.text(title),
        warnings=[shown(one, catalogue) for one in warnings],
        lines=[shown(one, catalogue) for one in lines],
    )


def _quality(survey: xr.Dataset, catalogue: Catalogue) -> Section:
    warnings = [
        Message("DAMAGED: {sentence}", sentence=one)
        for one in limited(sentences_of(survey, "faults"), LISTED)
    ]
    warnings += limited(dataset.missing_samples(survey), LISTED)
    lines = [
        labelled(name, one) for name in (DECISIONS, NOTES) for one in sentences_of(survey, name)
    ]
    section = _section(
        Message("Coverage and quality"), warnings, [*lines, *_remarks(survey)], catalogue
    )
    figure = maps.coverage_figure(survey, catalogue)
    section.figures.append((catalogue.tr("Coverage"), figure))
    if np.isfinite(survey[dataset.HEIGHT]).any():
        figure = maps.height_figure(survey, catalogue)
        section.figures.append((catalogue.tr("Antenna height above the ground"), figure))
    section.rows = [
        (
            catalogue.tr("{rotation_deg:g} deg", rotation_deg=turn),
            catalogue.tr(
                "{usable} of {total} samples usable", usable=int(own.sum()), total=own.size
            ),
        )
        for turn, own in zip(survey[dataset.POLARIZATION].values, dataset.usable(survey).values)
    ]
    return section


def _remarks(survey: xr.Dataset) -> List[Message]:
    remarks = survey["remarks"].values if "remarks" in survey else np.array([])
    return [
        Message(
            "remark of the robot on {count} samples: {remark}",
            count=np.count_nonzero(remarks == one),
            remark=str(one),
        )
        for one in sorted(set(remarks.ravel()))
        if one
    ]
