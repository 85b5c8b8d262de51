"""A report as PDF holds all that the page does, on pages that one can read."""

from __future__ import annotations

import random

import pypdfium2
import pytest
from matplotlib.figure import Figure
from survey_kit import POINTS, make_survey

from gpr20_analysis.commands.main import main
from gpr20_analysis.report.pdf import write_pdf
from gpr20_analysis.report.records import Report, Section
from gpr20_common.catalogue import Catalogue

LETTERS = "abcdefghilmnoprstuvzáéñ±°ε²µ≤0123456789./$_^{}%&<>WM"


@pytest.fixture
def pages(tmp_path):
    """Return a function that writes a report and returns its pages."""

    def made(one):
        path = tmp_path / "r.pdf"
        write_pdf(path, one, Catalogue())
        return list(pypdfium2.PdfDocument(path))

    return made


def text_of(page):
    return page.get_textpage().get_text_bounded().replace("\r\n", "\n")


def images_of(page):
    kind = pypdfium2.raw.FPDF_PAGEOBJ_IMAGE
    return [one.get_bounds() for one in page.get_objects(filter=[kind])]


def random_text(draw, most):
    words = ("".join(draw.choices(LETTERS, k=draw.choice((1, 4, 8, 90)))) for _ in range(most))
    return " ".join(list(words)[: draw.randint(1, most)])


def test_every_page_says_what_the_list_is_not_and_its_number(pages):
    rows = [(f"C{number}", "a\nb\nc") for number in range(60)]
    report = Report("Survey", [Section("t", rows=rows)], banner="SIMULATED", footer="No clearance")
    texts = list(map(text_of, pages(report)))
    assert len(texts) > 2
    for number, text in enumerate(texts, 1):
        assert text.count("SIMULATED") == text.count("No clearance") == 1
        assert f"page {number} of {len(texts)}, Survey" in text


def test_each_page_of_a_table_has_its_titles_and_every_row_is_there_once(pages):
    rows = [(f"C{number};", "one line\nanother\na third") for number in range(100)]
    texts = list(
        map(text_of, pages(Report("t", [Section("t", rows=rows, heading=("id", "flags"))])))
    )
    assert len(texts) > 3
    assert all(text.count("flags") == 1 for text in texts)
    assert [sum(text.count(name) for text in texts) for name, _ in rows] == 100 * [1]


def test_letters_that_the_font_lacks_are_shown_by_their_codes(pages):
    (page,) = pages(Report("日 á", [Section("t", lines=("地雷 ñ",), rows=[("雷", "x")])]))
    text = text_of(page)
    for shown in ("\\u65e5 á", "\\u5730\\u96f7 ñ", "\\u96f7 x"):
        assert shown in text.replace("\n", " ")


def test_a_heading_is_never_the_last_line_of_a_page(pages):
    sections = [Section(f"heading {n}", rows=[(f"{n}", "x")] * (n % 5 + 1)) for n in range(40)]
    for page in pages(Report("t", sections)):
        *_, last = text_of(page).splitlines()
        assert not last.startswith("heading")


def test_a_row_that_is_higher_than_a_page_goes_on_on_the_next(pages):
    notes = [f"line {number};" for number in range(200)]
    rows = [("notes", "\n".join(notes)), ("size", "1 MB")]
    whole = "\n".join(map(text_of, pages(Report("t", [Section("t", rows=rows)]))))
    assert [whole.count(line) for line in notes] == 200 * [1]
    assert "1 MB" in whole


def test_words_of_a_survey_are_never_markup(pages):
    words = "<b>&amp;"
    section = Section(words, words, [words], [words], [(words,)])
    (page,) = pages(Report(words, [section], footer=words))
    assert text_of(page).count(words) == 8


@pytest.mark.parametrize("columns", [2, 9])
def test_no_letter_is_beyond_the_margins(pages, columns):
    draw = random.Random(columns)
    rows = [tuple(random_text(draw, 9) for _ in range(columns)) for _ in range(20)]
    heading = tuple(random_text(draw, 2) for _ in range(columns))
    section = Section("t", random_text(draw, 60), [random_text(draw, 60)], rows=rows)
    section.heading = heading
    for page in pages(Report(random_text(draw, 9), [section], banner="b", footer="f")):
        text = page.get_textpage()
        boxes = [text.get_charbox(index) for index in range(text.count_chars())]
        assert min(left for left, *_ in boxes) > 40.0
        assert max(right for _, _, right, _ in boxes) < page.get_width() - 40.0
        assert min(bottom for _, bottom, _, _ in boxes) > 5.0


def test_a_figure_of_any_shape_fits_and_is_beside_its_caption(pages):
    sizes_in = [(9.5, 3.9), (5.2, 5.4), (3.0, 30.0)]
    figures = [(f"figure {n}", Figure(figsize=size)) for n, size in enumerate(sizes_in)]
    found = pages(Report("t", [Section("t", figures=figures)], mark="SIMULATED"))
    assert sum(len(images_of(page)) for page in found) == 3
    for page in found:
        assert text_of(page).count("(SIMULATED)") == len(images_of(page))
        for left, bottom, right, top in images_of(page):
            assert left > 40.0 and right < page.get_width() - 40.0
            assert bottom > 40.0 and top < page.get_height() - 40.0


def test_the_command_writes_what_the_page_says_with_its_figures(tmp_path):
    survey = make_survey(tmp_path, len(POINTS), "finished")
    output = tmp_path / "r.pdf"
    options = ["--permittivity", "4", "--depth", "0", "0.02", "0.005", "--height", "0.03"]
    assert main(["report", str(survey), "--output", str(output), *options]) == 0
    found = list(pypdfium2.PdfDocument(output))
    whole = "\n".join(map(text_of, found))
    for words in ("complete and intact", "Coverage", "B-scan along x", "Maximum projections"):
        assert words in whole
    assert sum(len(images_of(page)) for page in found) >= 6
