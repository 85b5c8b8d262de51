"""Every page has short lines and no dead links; it all stays short; the pins are the robot's."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import yaml
from case_kit import each_case

ROOT = Path(__file__).resolve().parents[5]
LONGEST_LINE = 100
# What a person reads: the README and docs/ without docs/reference, which is looked up.
MOST_WORDS, MOST_WORDS_OF_README = 33_000, 900


def project_files():
    """Return the paths of all files but those that git ignores."""
    listed = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"],
        cwd=str(ROOT),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return [name for name in listed.stdout.splitlines() if (ROOT / name).exists()]


def without_fences(text):
    """Return the text without its code blocks."""
    return re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(path):
    """Return the anchors of the headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", without_fences(path.read_text(encoding="utf-8")), re.M)
    # A link in a heading counts by its text.
    texts = [re.sub(r"\[(.*?)\]\(.*?\)", r"\1", heading) for heading in headings]
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in texts}


def link_targets(text):
    """Return the targets of inline and reference-style links that are no URLs."""
    inline = re.findall(r"\]\(([^)\s]+)\)", text)
    references = re.findall(r"^\[[^\]]+\]: (\S+)$", text, re.MULTILINE)
    return [target for target in inline + references if "://" not in target]


FILES = project_files()
each_document = each_case("document", [ROOT / name for name in FILES if name.endswith(".md")])


@each_document
def test_no_line_is_longer_than_the_limit(document):
    lines = document.read_text(encoding="utf-8").splitlines()
    too_long = [
        f"{document.relative_to(ROOT)}:{number}"
        for number, line in enumerate(lines, 1)
        if len(re.sub(r"https?://\S+", "", line)) > LONGEST_LINE
    ]
    assert too_long == [], f"break the lines of more than {LONGEST_LINE} characters"


@each_document
def test_every_link_leads_to_a_file_and_a_heading_that_exist(document):
    broken = []
    for target in link_targets(without_fences(document.read_text(encoding="utf-8"))):
        name, _hash, anchor = target.partition("#")
        path = (document.parent / name).resolve() if name else document
        if not path.exists() or (anchor and anchor not in anchors(path)):
            broken.append(target)
    assert broken == []


def test_what_a_person_reads_outside_the_reference_stays_short():
    pages = [name for name in FILES if re.fullmatch(r"README\.md|docs/(?!reference/).*\.md", name)]
    words = {name: len((ROOT / name).read_text(encoding="utf-8").split()) for name in pages}
    assert words["README.md"] <= MOST_WORDS_OF_README
    longest = sorted(words.items(), key=lambda one: -one[1])[:5]
    assert sum(words.values()) <= MOST_WORDS, f"shorten a page; the longest are {longest}"


def test_the_first_page_and_its_picture_have_the_pins_of_the_default_configuration():
    axes = yaml.safe_load((ROOT / "catkin_ws/src/gpr20_launch/config/axes.yaml").read_text())
    signals = {"direction": "dir_pin", "step": "step_pin", "endstop": "sensor_pin"}
    pins = {
        f"{axis.upper()} {signal}": values[key]
        for axis, values in axes.items()
        for signal, key in signals.items()
        if key in values
    }
    page = (ROOT / "docs/first_real_survey.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| ([XYZ] \w+) \|", page, re.MULTILINE)
    assert {signal: int(pin) for pin, signal in rows} == pins
    picture = (ROOT / "docs/images/wiring.svg").read_text(encoding="utf-8")
    assert [one for one in pins.items() if ">{} {}<".format(*one) not in picture] == []
