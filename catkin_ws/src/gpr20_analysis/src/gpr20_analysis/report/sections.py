"""The sections of a survey's report, in order."""

from __future__ import annotations

import datetime
import platform
from importlib import metadata
from pathlib import Path
from typing import Callable, List, Optional, Sequence

import numpy as np
import xarray as xr

from gpr20_analysis import __version__, dataset
from gpr20_analysis.candidates.marker_list import marker_heading, marker_rows, survey_markers
from gpr20_analysis.errors import AnalysisError
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.plotting import maps
from gpr20_analysis.plotting.hiding import hiding_figure
from gpr20_analysis.processing.chain import Step
from gpr20_analysis.read.verification import FILES, Verification, verify_survey
from gpr20_analysis.report import pictures
from gpr20_analysis.report.drift import HEADING, drift_lines, drift_rows
from gpr20_analysis.report.records import Section
from gpr20_analysis.report.summary import SIMULATED, Row, settings_of, summary_of, warnings_of
from gpr20_analysis.sentences import (
    DECISIONS,
    DOUBTS,
    ENGLISH,
    NOTES,
    labelled,
    limited,
    sentences_of,
    shown,
)
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.catalogue import Catalogue
from gpr20_common.message import Message, numeral, verbatim
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap
from gpr20_survey.trace.utc_time import moment_text

LISTED = 50
"""Number of sentences of a list that the report shows."""
LIBRARIES = ("numpy", "scipy", "xarray", "h5py", "matplotlib", "rosbags", "mcap")


def sections_of(
    survey: xr.Dataset,
    path: Path,
    steps: Sequence[Step],
    options: ImageOptions,
    progress: Progress = no_progress,
    catalogue: Catalogue = ENGLISH,
    hiding: Optional[HidingMap] = None,
) -> List[Section]:
    """Return the sections of a survey's report.

    Args:
        survey: Dataset with `s21`.
        path: Where it was loaded from; the folder of a survey is verified.
        steps: The steps before imaging.
        options: How the image is made.
        progress: Shows the progress.
        catalogue: Language of the report.
        hiding: Where a mine could hide; None: there is no such section.

    Returns:
        The sections, in order: verdict and candidates first.
    """
    verdict, *verification = _checked(survey, path, catalogue)
    parts: List[Callable[[], Sequence[Section]]] = [
        lambda: [verdict],
        lambda: pictures.imaged(survey, steps, options, catalogue),
        lambda: [] if hiding is None else [_hiding(hiding, catalogue)],
        lambda: [_markers(survey, catalogue)],
        lambda: [_quality(survey, catalogue)],
        lambda: [pictures.as_measured(survey, options, catalogue)],
        lambda: [_table(Message("Survey"), summary_of(survey), catalogue)],
        lambda: [_table(Message("Measurement settings"), settings_of(survey), catalogue)],
        lambda: [_drift(survey, catalogue)],
        lambda: [_sensors(survey, catalogue)],
        lambda: verification,
        lambda: [_table(Message("Software versions"), versions(survey), catalogue)],
    ]
    return [one for part in progress(parts, len(parts)) for one in part() if not one.empty]


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


def _checked(survey: xr.Dataset, path: Path, catalogue: Catalogue) -> List[Section]:
    """Return the verdict and the verification, which come first."""
    warnings = [SIMULATED] if survey.attrs.get("simulated") else []
    good = []
    size, absent = survey[dataset.QUALITY].size, len(dataset.missing_samples(survey))
    if absent:
        warnings.append(
            Message(
                "{count} of {total} samples have no data: the ground below them was NOT searched",
                count=absent,
                total=size,
            )
        )
    else:
        good.append(Message("All {total} samples of the grid have data.", total=size))
    found = None
    if path.is_dir() and any((path / name).exists() for name in FILES):
        found = verify_survey(path)
        (warnings if found.status else good).append(found.verdict)
    else:
        good.append(
            Message("Only the folder of a survey can be verified against its plan and checksums.")
        )
    warnings += [*sentences_of(survey, DOUBTS), *limited(warnings_of(survey), LISTED)]
    verdict = _section(Message("Verdict"), warnings, good, catalogue)
    return [verdict, *([_verification(found, catalogue)] if found else [])]


def _verification(found: Verification, catalogue: Catalogue) -> Section:
    faults = limited(found.faults, LISTED)
    return _section(Message("Verification"), faults, found.notes, catalogue)


def _hiding(found: HidingMap, catalogue: Catalogue) -> Section:
    return Section(
        catalogue.tr("Where could a mine hide?"),
        catalogue.text(ONLY_THIS),
        lines=[
            shown(one, catalogue) for one in found.sentences if one not in (ONLY_THIS, SIMULATED)
        ],
        figures=[(catalogue.tr("Where could a mine hide?"), hiding_figure(found, catalogue))],
    )


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
