"""The report holds everything in one file, HTML or PDF, and says what is wrong first."""

import base64
import math
import random
import re

import pypdfium2
import pytest
from log_examples import NOW
from matplotlib.figure import Figure
from survey_kit import POINTS, describe_again, make_survey
from translation_kit import shown_is_translated  # noqa: F401

from gpr20_analysis.commands.main import main
from gpr20_analysis.report.page import page
from gpr20_analysis.report.pdf import write_pdf
from gpr20_analysis.report.records import Report, Section
from gpr20_common.catalogue import Catalogue
from gpr20_survey.folder.log_record import Kind
from gpr20_survey.folder.recovery import open_log, recover

ALL = len(POINTS)
OPTIONS = ["--permittivity", "4", "--depth", "0", "0.02", "0.005"]
LOW = ["--height", "0.03"]  # the sweep of these surveys shows short delays only


def report(tmp_path, stored, outcome, changes=None, more=LOW, annotation=()):
    folder = make_survey(tmp_path, stored, outcome, changes or {})
    assert main(["annotate", str(folder), *annotation]) == 0
    output = tmp_path / "report.html"
    status = main(["report", str(folder), "--output", str(output), *OPTIONS, *more])
    return status, output.read_text(encoding="utf-8")


@pytest.mark.timeout(300)
def test_the_page_loads_nothing_and_holds_its_figures_and_a_pdf_the_same(tmp_path, request):
    status, text = report(tmp_path, ALL, "finished")
    assert status == 0
    assert not re.search(r"(src|href)=\"(?!data:)", text)
    figures = re.findall(r"data:image/png;base64,([^\"]+)", text)
    assert len(figures) >= 6
    assert all(base64.b64decode(one).startswith(b"\x89PNG") for one in figures)
    (folder,) = (tmp_path / "data").iterdir()
    request.getfixturevalue("blank_figures")
    assert main(["report", str(folder), "-o", str(tmp_path / "r.pdf"), *OPTIONS, *LOW]) == 0
    pages = list(pypdfium2.PdfDocument(tmp_path / "r.pdf"))
    assert sum(len(images_of(one)) for one in pages) >= 6
    whole = "\n".join(map(text_of, pages))
    for words in ("complete and intact", "Coverage", "B-scan along x", "Maximum projections"):
        assert words in text and words in whole
    assert main(["report", str(folder), "-o", str(tmp_path / "r.txt")]) == 3
    # The verdict comes first, then how it was measured.
    assert text.index('<section class="good"><h2>Verdict</h2>') < text.index("<h2>Survey</h2>")
    assert "3 stops from 10.0 to 20.0 mm" in text and "Data after the steps" in text


@pytest.mark.usefixtures("blank_figures")
def test_a_spanish_report_has_decimal_commas_and_days_first(tmp_path):
    _status, text = report(tmp_path, ALL, "finished", more=[*LOW, "--language", "es"])
    text = text[: text.index("<h2>Versiones")]
    shown = re.sub("<[^>]*>", " ", re.sub("(?s)<style>.*?</style>", "", text))
    assert re.search(r"\d,\d", shown) and re.search(r"\d\d/\d\d/\d{4} \d\d:", shown)
    # Addresses and versions have more points.
    found = re.findall(r".{20}(?<![\w.])\d+\.\d+(?![\w.]).{9}|\d{4}-\d\d-\d\d.{9}", shown)
    assert found == []


@pytest.mark.usefixtures("blank_figures")
def test_missing_samples_are_the_first_thing_that_is_said(tmp_path):
    status, text = report(tmp_path, ALL - 4, "stopped")
    assert status == 1
    assert text.index("4 of 18 samples have no data") < text.index("Coverage and quality")
    assert "No image was made" in text
    assert "missing: x " in text


@pytest.mark.usefixtures("blank_figures")
def test_warnings_of_the_robot_are_shown_in_the_language_of_the_reader(tmp_path, capsys):
    message = {"sentence": "Set back by {step_s:.1f} s.", "values": {"step_s": 120.0}}
    warning = {"time": "2026-09-21T14:13:20+00:00", "warning": "set back", "warning_message": None}
    recorded = {"warnings": [warning, {**warning, "warning_message": message}, 7]}
    folder = make_survey(tmp_path, ALL, "finished")
    describe_again(folder, report=recorded)
    output = tmp_path / "report.html"
    main(["report", str(folder), "--output", str(output)])
    text = output.read_text(encoding="utf-8")
    for words in ("warning of the robot at 2026-09-21 14:13:20 UTC: set back", "120.0 s"):
        assert words in text[: text.index("<h2>Survey</h2>")]
    capsys.readouterr()
    assert main(["info", str(folder), "--language", "es"]) == 0
    assert "advertencia del robot del 21/09/2026 14:13:20 UTC" in capsys.readouterr().out


@pytest.mark.usefixtures("blank_figures")
def test_words_of_a_survey_are_never_markup(tmp_path):
    remark = "<script>alert(1)</script>"
    note = ["--operator", "Lucía Peña", "--notes", f"wet\n{remark}", "--position", "4.6,-74.1"]
    _, text = report(tmp_path, ALL, "finished", {2: {"quality": (remark,)}}, annotation=note)
    assert "<script>" not in text
    for words in ("Lucía Peña", "wet\n&lt;script&gt;", "4.6, -74.1", "complete and intact"):
        assert words in text
    assert "&lt;script&gt;" in text
    assert "<b>" not in page(
        Report("<b>", [Section("<b>", "<b>", ["<b>"], ["<b>"], [("<b>",)])], footer="<b>")
    )


def turn(gain_db, noise_db=-60.0, z_deg=0.0):
    figures = {"amplitude_rms_db": abs(gain_db), "phase_rms_deg": 1.5, "delay_ps": 2.0 * gain_db}
    return {"z_deg": z_deg, "gain_db": gain_db, "noise_db": noise_db, **figures}


def note_again(folder, *visits):
    """Let the log of a survey have these visits of the first stop, and no others."""
    describe_again(folder)
    log = open_log(folder, recover(folder), NOW)
    for one in visits:
        log.add(log.next(Kind.DRIFT, one, NOW))


@pytest.mark.usefixtures("blank_figures")
def test_drift_repeatability_and_noise_are_shown_with_their_number_of_visits(tmp_path):
    # Without heights there is no image, which takes most of the time.
    blind = {index: {"antennae_height_m": math.nan} for index in range(ALL)}
    folder = make_survey(tmp_path, ALL, "finished", blind)
    output = tmp_path / "report.html"

    def text_with(*visits):
        note_again(folder, *visits)
        main(["report", str(folder), "--output", str(output), "--overwrite"])
        return output.read_text(encoding="utf-8")

    visit = {"time": "2026-09-21T15:00:00+00:00", "next_index": 6, "exceeded": False}
    visit.update(limit_db=0.25, limit_deg=10.0)
    visits = [
        {**visit, "rotations": [turn(0.1), turn(0.2, None, 90.0)]},
        {**visit, "rotations": [turn(-0.3, -55.0), turn(0.2, -70.0, 90.0)], "exceeded": True},
    ]
    text = text_with(*visits)
    for words in (
        "at most 0.300 dB and the phase by at most 1.50 deg",
        "at most -55.0 dB (pairs: 4)",
        # Of 0.1 and -0.3: 0.4 / sqrt(2).
        "of 2 visits: gain 0.283 dB, delay 0.57 ps",
        "the drift exceeded 0.25 dB or 10.0 deg at 1 visits",
    ):
        assert words in text
    text = text_with()
    for words in ("Drift was not measured", "not measured", "No image was made"):
        assert words in text
    assert "Drift and repeatability" in text_with({"rotations": [7, {}]})


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


def test_every_page_says_what_the_list_is_not_and_its_number_and_has_each_row_once(pages):
    rows = [(f"C{number};", "one line\nanother\na third") for number in range(100)]
    section = Section("t", rows=rows, heading=("id", "flags"))
    report = Report("Survey", [section], banner="SIMULATED", footer="No clearance")
    texts = list(map(text_of, pages(report)))
    assert len(texts) > 3
    for number, text in enumerate(texts, 1):
        assert text.count("SIMULATED") == text.count("No clearance") == text.count("flags") == 1
        assert f"page {number} of {len(texts)}, Survey" in text
    assert [sum(text.count(name) for text in texts) for name, _ in rows] == 100 * [1]
    # A row that is higher than a page continues on the next page.
    notes = [f"line {number};" for number in range(200)]
    whole = "\n".join(
        map(text_of, pages(Report("t", [Section("t", rows=[("n", "\n".join(notes))])])))
    )
    assert [whole.count(line) for line in notes] == 200 * [1]


def test_a_text_is_never_markup_and_letters_that_the_font_lacks_are_codes(pages):
    words = "<b>&amp;"
    (one,) = pages(
        Report(words, [Section(words, words, [words], [words], [(words,)])], footer=words)
    )
    assert text_of(one).count(words) == 8
    (one,) = pages(Report("日 á", [Section("t", lines=("地雷 ñ",))]))
    shown = text_of(one).replace("\n", " ")
    assert "\\u65e5 á" in shown and "\\u5730\\u96f7 ñ" in shown


def test_no_letter_is_beyond_the_margins(pages):
    columns = 9
    draw = random.Random(columns)
    rows = [tuple(random_text(draw, 9) for _ in range(columns)) for _ in range(8)]
    heading = tuple(random_text(draw, 2) for _ in range(columns))
    section = Section("t", random_text(draw, 60), [random_text(draw, 60)], rows=rows)
    section.heading = heading
    for one in pages(Report(random_text(draw, 9), [section], banner="b", footer="f")):
        text = one.get_textpage()
        boxes = [text.get_charbox(index) for index in range(text.count_chars())]
        assert min(left for left, *_ in boxes) > 40.0
        assert max(right for _, _, right, _ in boxes) < one.get_width() - 40.0
        assert min(bottom for _, bottom, _, _ in boxes) > 5.0


def test_a_figure_of_any_shape_fits_and_is_beside_its_caption(pages):
    sizes_in = [(9.5, 3.9), (5.2, 5.4), (3.0, 30.0)]
    figures = [(f"figure {n}", Figure(figsize=size)) for n, size in enumerate(sizes_in)]
    found = pages(Report("t", [Section("t", figures=figures)], mark="SIMULATED"))
    assert sum(len(images_of(page)) for page in found) == 3
    for one in found:
        assert text_of(one).count("(SIMULATED)") == len(images_of(one))
        for left, bottom, right, top in images_of(one):
            assert left > 40.0 and right < one.get_width() - 40.0
            assert bottom > 40.0 and top < one.get_height() - 40.0
