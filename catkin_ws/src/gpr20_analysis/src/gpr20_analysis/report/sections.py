"""The report of a survey: its sections in the order in which an officer asks."""

from __future__ import annotations

import datetime
import math
from pathlib import Path
from typing import TYPE_CHECKING, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import xarray as xr

from gpr20_analysis import __version__, dataset
from gpr20_analysis.candidates.answer import Answer, answer
from gpr20_analysis.candidates.table import (
    candidate_table,
    marker_heading,
    marker_rows,
    places_sentence,
    survey_markers,
    weaker_sentence,
)
from gpr20_analysis.errors import AnalysisError, check_ending
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.imaging.permittivity import permittivity_line
from gpr20_analysis.plotting import maps, scans
from gpr20_analysis.processing.chain import Step, apply_steps
from gpr20_analysis.processing.delay import to_time
from gpr20_analysis.read.checks import found_rows
from gpr20_analysis.read.load import load_survey
from gpr20_analysis.read.survey_attributes import NAME, SITE
from gpr20_analysis.read.verification import FILES, verify_survey
from gpr20_analysis.report.page import HTML, Report, Section, save_report
from gpr20_analysis.report.summary import SIMULATED, summary_of, warnings_of
from gpr20_analysis.sentences import (
    DECISIONS,
    DOUBTS,
    FAULTS,
    NOTES,
    labelled,
    limited,
    sentences_of,
    shown,
)
from gpr20_analysis.work import Progress, no_progress
from gpr20_common.catalogue import Catalogue, Language, language_from_code, read_catalogue
from gpr20_common.message import Message, numeral, verbatim
from gpr20_common.mid.checks import with_unit
from gpr20_survey.folder.log_record import Kind, log_values
from gpr20_survey.folder.survey_folder import LOG_FILE
from gpr20_survey.results.candidates import NO_CLEARANCE, CandidateList
from gpr20_survey.results.candidates import SIMULATED as SIMULATED_LIST
from gpr20_survey.results.hiding_map import ONLY_THIS, HidingMap
from gpr20_survey.trace.utc_time import moment_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LISTED = 50
"""Number of sentences of a list that the report shows."""


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
        progress: Shows the progress of the image.
        hiding: Where a mine could hide; None: the report has no such map.

    Raises:
        AnalysisError: The file has another ending or cannot be written.
    """
    check_ending(Path(output), (HTML,))
    options, known = options or ImageOptions(), language_from_code(language)
    catalogue = read_catalogue(known)
    found: Optional[Answer] = None
    try:
        found = answer(apply_steps(survey, steps, load_survey), options, progress)
    except AnalysisError as error:
        # The survey gets a report too, which says why it cannot be imaged.
        none = Message("No image was made: {reason}", reason=error.message)
        places = _section(Message("Places to check"), [none], [], catalogue)
        places.notice = catalogue.text(NO_CLEARANCE)
    else:
        places = places_section(found.found, catalogue)
        figure = maps.candidate_map_figure(found.image, found.found.shown(), catalogue)
        places.figures.append(figure)
    sections = [
        places,
        _missed(survey, found, hiding, catalogue),
        _believed(survey, Path(path), found, catalogue),
        *([] if found is None else [_image(found, steps, options, catalogue)]),
        *_found(Path(path), catalogue),
        *_markers(survey, catalogue),
        _quality(survey, catalogue),
        _measured(survey, options, catalogue),
        _settings(survey, catalogue),
    ]
    banner = catalogue.text(SIMULATED) if survey.attrs.get("simulated") else ""
    save_report(Report(title_of(survey, catalogue), sections, known, banner), Path(output))


def title_of(survey: xr.Dataset, catalogue: Catalogue) -> str:
    """Return name, site and date of a survey; without any of them its source."""
    known = survey.attrs
    day = str(known.get("started", ""))[:10]
    parts = [str(one) for one in (known.get(NAME), known.get(SITE), day) if one]
    name = ", ".join(parts) or str(known.get("source", ""))
    return catalogue.tr("GPR-20 survey {name}", name=name)


def places_section(found: CandidateList, catalogue: Catalogue) -> Section:
    """Return how many places there are to check, and where."""
    heading, *rows = candidate_table(found, found.candidates, catalogue)
    return Section(
        catalogue.tr("Places to check: {count}", count=found.primary),
        catalogue.text(NO_CLEARANCE),
        lines=[catalogue.text(places_sentence(found))],
        heading=heading,
        rows=rows[: found.primary],
        more=(
            catalogue.text(weaker_sentence(found)) if found.weaker else "",
            rows[found.primary :],
        ),
    )


def _section(
    title: Message, warnings: Sequence[Message], lines: Sequence[Message], catalogue: Catalogue
) -> Section:
    return Section(
        catalogue.text(title),
        warnings=[shown(one, catalogue) for one in warnings],
        lines=[shown(one, catalogue) for one in lines],
    )


def _missed(
    survey: xr.Dataset, found: Optional[Answer], hiding: Optional[HidingMap], catalogue: Catalogue
) -> Section:
    """Return what could have been missed: ground without data, and the map of what can hide."""
    size, absent = survey[dataset.QUALITY].size, len(dataset.missing_samples(survey))
    warnings, lines = [], []
    if absent:
        warnings.append(
            Message(
                "{count} of {total} samples have no data: the ground below them was NOT searched",
                count=absent,
                total=size,
            )
        )
    else:
        lines.append(Message("All {total} samples of the grid have data.", total=size))
    if hiding is None:
        lines.append(
            Message(
                "There is no map of where a mine could hide: make one with gpr20 hiding, and give "
                "it with --hiding. What this radar does not see is on no list."
            )
        )
    else:
        soil = hiding.permittivity if found is None else found.found.permittivity
        if not math.isclose(soil, hiding.permittivity, rel_tol=0.01):
            warnings.append(
                Message(
                    "The map of where a mine could hide is for the permittivity {other:.3g}, the "
                    "places are for {soil:.3g}: make the map again for this soil",
                    other=hiding.permittivity,
                    soil=soil,
                )
            )
        left_out = (ONLY_THIS, SIMULATED_LIST)
        lines += [one for one in hiding.sentences if one not in left_out]
    section = _section(Message("What could have been missed"), warnings, lines, catalogue)
    if hiding is not None:
        section.notice = catalogue.text(ONLY_THIS)
        section.figures.append(maps.hiding_figure(hiding, catalogue))
    return section


def _believed(
    survey: xr.Dataset, path: Path, found: Optional[Answer], catalogue: Catalogue
) -> Section:
    """Return how far the data can be believed, and what the verification found."""
    warnings = [SIMULATED] if survey.attrs.get("simulated") else []
    good: List[Message] = []
    if path.is_dir() and any((path / name).exists() for name in FILES):
        checked = verify_survey(path)
        (warnings if checked.status else good).append(checked.verdict)
        warnings += limited(checked.faults, LISTED)
        good += checked.notes
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
    return _section(Message("How far the data can be believed"), warnings, good, catalogue)


def _image(
    found: Answer, steps: Sequence[Step], options: ImageOptions, catalogue: Catalogue
) -> Section:
    """Return the image, how it was made, and the data from which it was made."""
    image, permittivity = found.image, float(found.image.attrs["permittivity"])
    height_m = options.height_m
    lines = [
        Message(
            "Depths to {deepest_mm:.0f} mm, method {method}, height of the antennas {height}.",
            deepest_mm=float(image[dataset.DEPTH][-1]) * dataset.MM_PER_M,
            method=options.method.name,
            height=Message("as recorded") if height_m is None else with_unit(height_m, "m"),
        ),
        *(Message("step: {step}", step=_step_text(one)) for one in steps),
    ]
    section = _section(Message("Image of the ground"), [], lines, catalogue)
    section.figures += [
        maps.projection_figure(image, turn, found.found.shown(), catalogue)
        for turn in range(image.sizes[dataset.POLARIZATION])
    ]
    section.figures += _b_scans(to_time(found.processed), permittivity, catalogue)
    return section


def _step_text(step: Step) -> str:
    values = ", ".join(f"{key} {value}" for key, value in step.parameters.items())
    return f"{step.name} ({values})" if values else step.name


def _b_scans(
    in_time: xr.Dataset, permittivity: Optional[float], catalogue: Catalogue
) -> List[Figure]:
    return [
        scans.b_scan_figure(in_time, along, at_m, None, permittivity, catalogue)
        for along, at_m in zip((dataset.X, dataset.Y), reversed(_middle(in_time)))
        if in_time.sizes[along] > 1
    ]


def _middle(survey: xr.Dataset) -> Tuple[float, float]:
    x_m, y_m = (float(survey[axis][survey.sizes[axis] // 2]) for axis in (dataset.X, dataset.Y))
    return x_m, y_m


def _found(path: Path, catalogue: Catalogue) -> List[Section]:
    """Return what people found where they dug, of a survey's folder."""
    rows = found_rows(path) if (path / LOG_FILE).is_file() else []
    tr = catalogue.tr
    heading = (
        *(tr("candidate"), tr("x mm"), tr("y mm"), tr("found"), tr("depth mm")),
        *(tr("operator"), tr("time"), tr("notes")),
    )
    return [Section(tr("What people found"), heading=heading, rows=rows)] if rows else []


def _markers(survey: xr.Dataset, catalogue: Catalogue) -> List[Section]:
    title = Message("Markers")
    try:
        found = survey_markers(survey)
    except AnalysisError as error:
        return [_section(title, [error.message], [], catalogue)]
    rows, heading = marker_rows(found, catalogue), marker_heading(catalogue)
    return [Section(catalogue.text(title), heading=heading, rows=rows)] if rows else []


def _quality(survey: xr.Dataset, catalogue: Catalogue) -> Section:
    """Return which samples have data, what was said of them, and what repeated visits showed."""
    damaged = (labelled(FAULTS, one) for one in sentences_of(survey, FAULTS))
    absent = dataset.missing_samples(survey)
    warnings = [*limited(list(damaged), LISTED), *limited(absent, LISTED)]
    lines = [
        labelled(name, one) for name in (DECISIONS, NOTES) for one in sentences_of(survey, name)
    ]
    lines += [*_remarks(survey), _drift(survey)]
    section = _section(Message("Coverage and quality"), warnings, lines, catalogue)
    section.figures.append(maps.coverage_figure(survey, catalogue))
    if np.isfinite(survey[dataset.HEIGHT]).any():
        section.figures.append(maps.height_figure(survey, catalogue))
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


def _drift(survey: xr.Dataset) -> Message:
    """Return how far the first stop differed when it was measured again."""
    visits = log_values(dataset.description_of(survey), Kind.DRIFT)
    turns = [turn for visit in visits for turn in dataset.objects_of(visit, "rotations")]
    if not turns:
        return Message("Drift was not measured: the survey did not return to its first stop.")
    worst: Dict[str, Message] = {}
    for name in ("amplitude_rms_db", "phase_rms_deg", "noise_db"):
        known = [turn[name] for turn in turns if isinstance(turn.get(name), (int, float))]
        worst[name] = numeral(max(known), ".4g") if known else verbatim("-")
    return Message(
        "Visits of the first stop: {count}. The amplitude drifted by at most {amplitude_rms_db} dB "
        "and the phase by at most {phase_rms_deg} deg, root mean square over the band. The noise "
        "of one sweep, relative to its signal, is at most {noise_db} dB.",
        count=len(visits),
        **worst,
    )


def _measured(survey: xr.Dataset, options: ImageOptions, catalogue: Catalogue) -> Section:
    """Return A- and B-scans before any processing."""
    in_time, (x_m, y_m) = to_time(survey), _middle(survey)
    section = _section(Message("Data as measured"), [], [], catalogue)
    if dataset.usable(survey).sel(x=x_m, y=y_m).values.any():
        section.figures.append(scans.a_scan_figure(in_time, x_m, y_m, catalogue=catalogue))
    section.figures += _b_scans(in_time, options.permittivity, catalogue)
    return section


def _settings(survey: xr.Dataset, catalogue: Catalogue) -> Section:
    """Return how the survey was measured, and by what the report was made."""
    now = datetime.datetime.now(datetime.timezone.utc)
    rows = [
        *summary_of(survey),
        (Message("report created"), moment_text(now.isoformat(timespec="seconds"))),
        (Message("software of the report"), verbatim(f"gpr20_analysis {__version__}")),
    ]
    texts = [tuple(shown(one, catalogue) for one in row) for row in rows]
    return Section(catalogue.tr("Survey and settings"), rows=texts)
