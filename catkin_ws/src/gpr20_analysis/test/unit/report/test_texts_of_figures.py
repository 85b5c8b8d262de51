"""Title, notes and captions never overlap the axes or each other, however long they are."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
from ground_kit import point, scene, survey_of

from gpr20_analysis.imaging.image import image_survey
from gpr20_analysis.imaging.image_options import ImageOptions
from gpr20_analysis.plotting import maps, projections, scans
from gpr20_analysis.plotting.noted_figure import NOTE_PT, NotedFigure, wrapped
from gpr20_analysis.processing.background import remove_background
from gpr20_analysis.processing.delay import to_time
from gpr20_common.low.catalogue_file import languages, read_catalogue

PLACES_MM = np.linspace(180.0, 300.0, 5)
SURVEY = survey_of(scene([point(243.7, 236.2, 0.083)]), PLACES_MM, PLACES_MM)
IN_TIME = to_time(remove_background(SURVEY))
IMAGE = image_survey(remove_background(SURVEY), ImageOptions(permittivity=4.0))
LANGUAGES = [read_catalogue(language) for language in languages()]
FIGURES = {
    "a-scan": lambda data, catalogue: scans.a_scan_figure(
        IN_TIME.assign_attrs(data), 0.24, 0.24, catalogue=catalogue
    ),
    "b-scan": lambda data, catalogue: scans.b_scan_figure(
        IN_TIME.assign_attrs(data), "x", 0.24, permittivity=4.0, catalogue=catalogue
    ),
    "c-scan": lambda data, catalogue: scans.c_scan_figure(
        IMAGE.assign_attrs(data), 0.083, catalogue
    ),
    "projections": lambda data, catalogue: projections.projection_figure(
        IMAGE.assign_attrs(data), 0, catalogue=catalogue
    ),
    "coverage": lambda data, catalogue: maps.coverage_figure(SURVEY.assign_attrs(data), catalogue),
}


def random_text(draw: random.Random, most: int = 60) -> str:
    letters = "abcdefghilmnoprstuvzáéñ0123456789./$_^{}%WM"
    words = ("".join(draw.choices(letters, k=draw.choice((1, 4, 8, 90)))) for _ in range(most))
    return " ".join(list(words)[: draw.randint(1, most)])


def boxes_of(figure: NotedFigure):
    figure.draw_without_rendering()
    texts = [figure._suptitle, figure._supxlabel]
    return (
        [one.get_window_extent() for one in texts if one.get_text()],
        [axes.get_tightbbox() for axes in figure.axes if axes.axison],
    )


def overlap(one, other) -> bool:
    wide = min(one.x1, other.x1) - max(one.x0, other.x0)
    high = min(one.y1, other.y1) - max(one.y0, other.y0)
    return wide > 1.0 and high > 1.0


def check(figure: NotedFigure) -> None:
    texts, panels = boxes_of(figure)
    page = figure.bbox
    for number, text in enumerate(texts):
        assert page.x0 <= text.x0 and text.x1 <= page.x1
        assert page.y0 <= text.y0 and text.y1 <= page.y1
        assert not any(overlap(text, other) for other in [*texts[number + 1 :], *panels])
    assert not any(
        overlap(one, other) for number, one in enumerate(panels) for other in panels[number + 1 :]
    )


@pytest.mark.parametrize(("name", "catalogue"), zip(FIGURES, itertools.cycle(LANGUAGES)))
def test_texts_are_apart_with_random_notes(name, catalogue):
    draw = random.Random(name)
    notes = [random_text(draw) for _ in range(draw.randint(0, 12))]
    plain = FIGURES[name]({}, catalogue)
    plain.draw_without_rendering()
    height = plain.axes[0].get_window_extent().height
    figure = FIGURES[name]({"notes": notes}, catalogue)
    check(figure)
    # The axes keep their size, because the figure grows.
    assert figure.axes[0].get_window_extent().height > 0.75 * height


def test_no_letter_of_a_wrapped_text_is_lost():
    draw = random.Random(7)
    for _ in range(20):
        text, width_in = random_text(draw), draw.uniform(1.0, 12.0)
        lines = wrapped([text], width_in, NOTE_PT)
        assert "".join("".join(lines).split()) == "".join(text.split())
