"""The page for those who come from the original names only what exists here."""

from __future__ import annotations

import re
from contextlib import redirect_stdout
from functools import lru_cache
from io import StringIO
from pathlib import Path

from case_kit import each_case
from wings_kit import NEEDS_ALL

from gpr20_analysis.commands.main import main

ROOT = Path(__file__).resolve().parents[5]
SOURCES = ROOT / "catkin_ws/src"
PAGE = (ROOT / "docs/coming_from_the_original.md").read_text(encoding="utf-8")


def rows():
    """Return heading and the column "here" of every row of every table."""
    found = []
    for section in re.split(r"^## ", PAGE, flags=re.MULTILINE)[1:]:
        heading = section.splitlines()[0]
        cells = re.findall(r"^\|([^|]*)\|([^|]*)\|([^|]*)\|$", section, re.MULTILINE)
        assert not cells or cells[0][1].strip() == "here", heading
        found += [(heading, own.strip()) for _, own, _ in cells[2:]]
    return found


def names(own):
    """Return the code spans of a cell; `.field` is one of the type before it."""
    spans, last = [], ""
    for span in re.findall(r"`([^`]+)`", own):
        last = span.split(".")[0] if not span.startswith(".") else last
        spans.append(last + span if span.startswith(".") else span)
    return spans


@lru_cache(maxsize=None)
def text_of(pattern):
    return "\n".join(one.read_text("utf-8") for one in sorted(SOURCES.glob(pattern)))


@lru_cache(maxsize=None)
def help_of(command):
    printed = StringIO()
    with redirect_stdout(printed):
        assert main([command, "--help"]) == 0
    return re.sub(r"\s+", "", printed.getvalue())


def is_package_or_node(name):
    return (SOURCES / name).is_dir() or any(SOURCES.glob(f"*/nodes/{name}"))


def is_interface(name):
    return f'"{name.split("/")[-1]}"' in text_of("gpr20_*/src/*/high/*.py")


def is_field(name):
    kind, _, field = name.partition(".")
    (path,) = SOURCES.glob(f"gpr20_msgs/*/{kind}.*")
    return not field or re.search(rf"^\S+ {field}\b", path.read_text("utf-8"), re.MULTILINE)


def is_launch_or_key(name):
    if name.endswith(".launch"):
        return (ROOT / "launch" / name).exists()
    return re.search(rf"^  {name}:", text_of("gpr20_launch/config/axes.yaml"), re.MULTILINE)


def is_on_the_window(name):
    shown = text_of("gpr20_user_interface/src/**/*.py") + text_of("gpr20_operator/src/**/*.py")
    return f'"{name}"' in shown


def is_command(name):
    _, command, *rest = name.split()
    shown = help_of(command)
    return all(word in shown for word in rest)


def is_code(name):
    kind, _, method = name.partition(".")
    found = re.findall(
        rf"^(?:class|def) {kind}\b.*?(?=^\S)", text_of("gpr20_*/src/*/**/*.py"), re.M | re.S
    )
    # The signature of a class may span lines, so its body is what is indented.
    return found and (
        not method or any(re.search(rf"^    def {method}\(", one, re.M) for one in found)
    )


CHECKS = {
    "Packages and nodes": is_package_or_node,
    "Topics, services, action": is_interface,
    "Types": is_field,
    "Launch files and parameters": is_launch_or_key,
    "Window": is_on_the_window,
    "Files": is_command,
    "Processing": is_command,
    "Classes and methods": is_code,
}


@each_case("heading, own", rows())
@NEEDS_ALL
def test_a_name_in_the_column_here_exists(heading, own):
    assert names(own), "a row without a name"
    for name in names(own):
        assert CHECKS[heading](name), name


def test_every_table_is_checked():
    assert {heading for heading, _ in rows()} == set(CHECKS)
