"""Keep the catalogues of translations; scripts/translations.sh starts it and says how.

Translated are the sentences of every module and program, unless pyproject.toml lists it: what only
analysts and maintainers read is English.
"""

from __future__ import annotations

import argparse
import ast
import sys
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, Set

import polib

from gpr20_common.catalogue import FOLDER, read_translations
from gpr20_common.errors import Gpr20Error

ROOT = Path(__file__).resolve().parents[2]
# The project translates everything into this language; others may have gaps, which are English.
COMPLETE = FOLDER / "es.po"
FUNCTIONS = ("Message", "tr")
# They pass on a template that was written elsewhere.
PASS_ON = tuple(f"gpr20_common/{name}.py" for name in ("message", "catalogue"))


def module_files() -> Dict[str, Path]:
    """Return the files of all modules and programs, by `package.module` or `package.program`."""
    found = {path.stem: path for path in ROOT.glob("deploy/*.py")}
    for folder in ROOT.glob("catkin_ws/src/*/src"):
        for path in folder.rglob("*.py"):
            found[".".join(path.relative_to(folder).with_suffix("").parts)] = path
    for path in ROOT.glob("catkin_ws/src/*/nodes/*"):
        found[f"{path.parts[-3]}.{path.name}"] = path
    return found


def shown_files() -> Set[Path]:
    """Return those of which operators may meet a sentence."""
    import tomllib  # Python 3.8 has none, and its tests look up templates only

    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    english = tuple(f"{one}." for one in settings["tool"]["translations"]["english_modules"])
    return {path for name, path in module_files().items() if not f"{name}.".startswith(english)}


def templates(source: str, passes_on: bool = False) -> Iterator[str]:
    """Yield the template of each Message(...) and tr(...) in a source text.

    Args:
        source: The text.
        passes_on: Whether it may pass on templates that are written elsewhere.

    Raises:
        ValueError: One is not a literal, so nobody could translate it.
    """
    calls = (one for one in ast.walk(ast.parse(source)) if isinstance(one, ast.Call) and one.args)
    for call in calls:
        template = call.args[0]
        if getattr(call.func, "attr", getattr(call.func, "id", "")) not in FUNCTIONS:
            continue
        if isinstance(template, ast.Constant) and isinstance(template.value, str):
            yield template.value
        elif not passes_on:
            raise ValueError(
                f"{template.lineno}: write the template as one literal string in Message(...) or "
                "tr(...), with {names} for the values and the values as further arguments"
            )


def templates_of(files: Iterable[Path]) -> Set[str]:
    """Return every template in some files."""
    found: Set[str] = set()
    for path in files:
        try:
            source = path.read_text(encoding="utf-8")
            found.update(templates(source, path.as_posix().endswith(PASS_ON)))
        except ValueError as error:
            raise ValueError(f"{path}:{error}") from error
    return found


def complaints(path: Path, wanted: Set[str]) -> List[str]:
    """Return what is wrong with a catalogue.

    Args:
        path: The catalogue.
        wanted: All templates that it may have, and must have if it is the complete one.
    """
    usable = set(read_translations(path))
    entries = polib.pofile(path.read_text(encoding="utf-8"), check_for_duplicates=True)
    translated = {one.msgid for one in entries.translated_entries()}
    missing = wanted - translated if path == COMPLETE else set()
    return [
        *(f"no program has {one.msgid!r}: not used" for one in entries if one.msgid not in wanted),
        *(f"give the msgstr the {{values}} of {one!r}" for one in sorted(translated - usable)),
        *(f"write the msgstr of {one!r}" for one in sorted(missing)),
    ]


def update(path: Path, wanted: Set[str]) -> None:
    """Write a catalogue with an entry for each template, in the order of the sentences.

    A sentence is one line: another wording changes that line, and a search finds it.
    """
    catalogue = polib.pofile(path.read_text(encoding="utf-8"), wrapwidth=0)
    known = {one.msgid: one.msgstr for one in catalogue.translated_entries()}
    entries = [polib.POEntry(msgid=one, msgstr=known.get(one, "")) for one in sorted(wanted)]
    catalogue[:] = entries
    catalogue.save(str(path))
    print(f"{path}: {len(known.keys() & wanted)} of {len(wanted)} are translated")


def main() -> None:
    """Update or check catalogues."""
    parser = argparse.ArgumentParser(prog="translations.sh")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("file", type=Path, nargs="?")
    chosen = parser.parse_args()
    paths = [chosen.file.resolve()] if chosen.file else sorted(FOLDER.glob("*.po"))
    wanted = templates_of(shown_files())
    for path in paths:
        if not chosen.check:
            update(path, wanted)
        if found := complaints(path, wanted):
            sys.exit("\n".join([f"translations.sh: {path}:", *found]))


if __name__ == "__main__":
    try:
        main()
    except (Gpr20Error, ValueError) as error:
        sys.exit(f"translations.sh: {error}")
