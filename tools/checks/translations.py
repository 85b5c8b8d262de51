"""Keep the catalogues of translations; scripts/translations.sh starts it and says how.

Translated is what an operator can meet: the sentences of every program in nodes/ and deploy/, and
of every module that one of them imports or names, directly or not. Programs that only analysts and
maintainers use are listed in pyproject.toml: what only they say is English.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from pathlib import Path
from typing import Dict, Iterable, Iterator, List, Set

import polib

import gpr20_analysis
from gpr20_common.errors import Gpr20Error
from gpr20_common.low.catalogue_file import FOLDER, read_translations

ROOT = Path(__file__).resolve().parents[2]
# The project translates everything into this language; others may have gaps, which are English.
COMPLETE = FOLDER / "es.po"
FUNCTIONS = ("Message", "tr")
# They pass on a template that was written elsewhere.
PASS_ON = tuple(f"gpr20_common/{name}.py" for name in ("message", "sent_message", "catalogue"))
NAMED = re.compile(r"\bgpr20_\w+(?:\.\w+)+")
LANGUAGE = re.compile("[a-z]{2,3}(_[A-Z]{2})?")


def shown_files() -> Set[Path]:
    """Return the files of all programs that operators use, and of all modules that these reach."""
    import tomllib  # Python 3.8 has none, and its tests look up templates only

    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    chosen = settings["tool"]["translations"]
    modules = module_files()
    waiting = [modules[name] for name in chosen["loaded_by_configuration"]]
    for path in (*ROOT.glob("catkin_ws/src/*/nodes/*"), *ROOT.glob("deploy/*.py")):
        if path.is_file() and path.name not in chosen["english_programs"]:
            waiting.append(path)
    found: Set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _reached(path, modules)
    return found


def module_files() -> Dict[str, Path]:
    """Return the file of each module of the packages."""
    found = {}
    for folder in ROOT.glob("catkin_ws/src/*/src"):
        for path in folder.rglob("*.py"):
            parts = path.relative_to(folder).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def _reached(path: Path, modules: Dict[str, Path]) -> Iterator[Path]:
    """Yield the modules that a file imports, uses by the public interface, or names in a text."""
    homes = {
        f"gpr20_analysis.{name}": f"gpr20_analysis.{module}"
        for module, names in gpr20_analysis._HOMES.items()
        for name in names
    }
    for name in _names(ast.parse(path.read_text(encoding="utf-8"))):
        name = homes.get(name, name)
        # What is no module is something in one.
        while name not in modules and "." in name:
            name = name.rpartition(".")[0]
        if name in modules:
            yield modules[name]


def _names(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (one.name for one in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{one.name}" for one in node.names)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            yield f"{node.value.id}.{node.attr}"
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield from NAMED.findall(node.value)


def templates(source: str, passes_on: bool = False) -> Iterator[str]:
    """Yield the template of each Message(...) and tr(...) in a source text.

    Args:
        source: The text.
        passes_on: Whether it may pass on templates that are written elsewhere.

    Raises:
        ValueError: One is not a literal, so nobody could translate it.
    """
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.Call) or not node.args:
            continue
        first = node.args[0]
        if getattr(node.func, "attr", getattr(node.func, "id", "")) not in FUNCTIONS:
            continue
        if isinstance(first, ast.Constant) and isinstance(first.value, str):
            yield first.value
        elif not passes_on:
            raise ValueError(
                f"{first.lineno}: write the template as one literal string in Message(...) or "
                "tr(...), with {names} for the values and the values as further arguments"
            )


def templates_of(files: Iterable[Path]) -> Set[str]:
    """Return every template in some files."""
    found: Set[str] = set()
    for path in files:
        try:
            passes_on = path.as_posix().endswith(PASS_ON)
            found.update(templates(path.read_text(encoding="utf-8"), passes_on))
        except ValueError as error:
            raise ValueError(f"{path.relative_to(ROOT)}:{error}") from error
    return found


def complaints(path: Path, wanted: Set[str]) -> List[str]:
    """Return what is wrong with a catalogue.

    Args:
        path: The catalogue.
        wanted: All templates that it may have, and must have if it is the complete one.
    """
    used = read_translations(path)
    entries = polib.pofile(path.read_text(encoding="utf-8"), check_for_duplicates=True)
    found = [f"not used by any program: {one.msgid}" for one in entries if one.msgid not in wanted]
    translated = {one.msgid for one in entries.translated_entries()}
    found += [f"has other {{values}} than its msgid: {one}" for one in translated - set(used)]
    if path == COMPLETE:
        found += [f"not translated: {one}" for one in sorted(wanted - translated)]
    return [f"{path}: {one}" for one in found]


def update(path: Path, wanted: Set[str]) -> None:
    """Write a catalogue with an entry for each template, in the order of the sentences.

    A sentence is one line: another wording changes that line, and a search finds it.
    """
    catalogue = polib.pofile(path.read_text(encoding="utf-8"), wrapwidth=0)
    known = {one.msgid: one.msgstr for one in catalogue.translated_entries()}
    catalogue[:] = [
        polib.POEntry(msgid=one, msgstr=known.get(one, "")) for one in sorted(wanted - {""})
    ]
    catalogue.save(str(path))
    print(f"{path}: {len(catalogue.untranslated_entries())} of {len(catalogue)} to translate")
    if path == COMPLETE:
        for line in complaints(path, wanted):
            print(line, file=sys.stderr)


def begin(path: Path, language: str) -> None:
    """Write a catalogue without entries."""
    if path.exists() or not language or not LANGUAGE.fullmatch(path.stem):
        sys.exit("translations.sh: name a new file and its language: --new pt.po Português")
    catalogue = polib.POFile()
    catalogue.metadata = {
        **{"Project-Id-Version": "gpr20", "Language": path.stem, "X-Language-Name": language},
        **{"MIME-Version": "1.0", "Content-Type": "text/plain; charset=UTF-8"},
        "Content-Transfer-Encoding": "8bit",
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    catalogue.save(str(path))


def main() -> None:
    """Update, check or begin catalogues."""
    parser = argparse.ArgumentParser(prog="translations.sh")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--new", action="store_true")
    parser.add_argument("file", type=Path, nargs="?")
    parser.add_argument("language", nargs="?", default="")
    chosen = parser.parse_args()
    if chosen.new:
        begin(chosen.file or Path(), chosen.language)
    wanted = templates_of(shown_files())
    found: List[str] = []
    for path in [chosen.file.resolve()] if chosen.file else sorted(FOLDER.glob("*.po")):
        if chosen.check:
            found += complaints(path, wanted)
        else:
            update(path, wanted)
    if found:
        sys.exit("\n".join([*found, "run scripts/translations.sh, then write what it names"]))


if __name__ == "__main__":
    try:
        main()
    except (Gpr20Error, ValueError) as error:
        sys.exit(f"translations.sh: {error}")
