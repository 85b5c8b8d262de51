"""What MkDocs calls while it builds the site (mkdocs.yml).

The site has each page where the repository has it, so links between pages need no change. Beside
docs/ it has the READMEs of the packages, some pages of the project, and the files that pages link.
"""

from __future__ import annotations

import importlib
import itertools
import posixpath
import re
import tempfile
import warnings
from pathlib import Path
from typing import Any, Iterator, List

import pdoc
from markdown import Extension, Markdown
from markdown.preprocessors import Preprocessor
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

import gpr20_analysis
from gpr20_common.catalogue import Catalogue, Language, read_catalogue
from gpr20_common.message import Fault, Severity

ROOT = Path(__file__).resolve().parents[2]
INTERFACES = "catkin_ws/src/gpr20_msgs/README.md"
KINDS = {"msg": "Messages", "srv": "Services", "action": "Actions"}
API = '\n<a href="../../api/gpr20_analysis.html">The complete reference</a>\n'
FRONT = '<meta http-equiv="refresh" content="0; url=docs/index.html">\n'
# Of a link in a line and of one by reference: what stands before its target, and the target.
LINK = re.compile(r"(\]\(|^\[[^\]]+\]: +)([^)\s#]+)", re.MULTILINE)
ITEM = re.compile(r" *([-*+]|\d+[.)]) +\S")


class ListsOfGitHub(Extension):
    """Lists as GitHub reads them: no blank line before, as far to the right as their text."""

    def extendMarkdown(self, md: Markdown) -> None:  # noqa: N802 so named by Markdown
        """Add it before the other extensions; it works behind that which takes out the code."""
        md.tab_length = 2
        md.build_parser()
        md.preprocessors.register(_BlankBeforeLists(md), "blank_before_lists", 20)


class _BlankBeforeLists(Preprocessor):
    def run(self, lines: List[str]) -> List[str]:
        written: List[str] = []
        for line in lines:
            # What follows another item, or continues one, is in a list already.
            text = bool(written) and bool(re.match(r"\S", written[-1]))
            if ITEM.match(line) and text and not ITEM.match(written[-1]):
                written.append("")
            written.append(line)
        return written


def heading_anchor(text: str, separator: str = "-") -> str:
    """Return the anchor of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", separator)


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Read Markdown as GitHub does, and list the packages."""
    toc: Any = config.mdx_configs.setdefault("toc", {})
    toc["slugify"] = heading_anchor
    extensions: Any = config.markdown_extensions
    extensions.insert(0, ListsOfGitHub())
    packages = [one for one in _outside_pages() if one.startswith("catkin_ws/")]
    listed = [one for one in packages if one != INTERFACES]
    # Before the evidence, which is the last.
    nav: Any = config.nav
    nav.insert(-1, {"Packages": listed})
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Return the pages where the repository has them, what they link to, and the Python API."""
    pages = {f"docs/{one.src_uri}": one.content_string for one in files.documentation_pages()}
    pages.update({one: (ROOT / one).read_text("utf-8") for one in _outside_pages()})
    pages[INTERFACES] += _interfaces((ROOT / INTERFACES).parent)
    pages["docs/reference/messages.md"] += messages_markdown()
    pages["docs/reference/api.md"] += API
    # The style sheets, scripts and pictures of the site itself are also where its theme looks.
    made = [one for one in files if not one.is_documentation_page()]
    linked = {path for name, text in pages.items() for path in _linked_files(name, text)}
    for path in sorted(linked - pages.keys()):
        made.append(File.generated(config, path, abs_src_path=str(ROOT / path)))
    for name, text in pages.items():
        made.append(File.generated(config, name, content=text))
    made.append(File.generated(config, "index.html", content=FRONT))
    with tempfile.TemporaryDirectory() as folder:
        for page in write_api(Path(folder)):
            name = page.relative_to(folder).as_posix()
            made.append(File.generated(config, f"api/{name}", content=page.read_bytes()))
    return Files(made)


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Return the text of a page, with links to what stands for a folder, or for the README."""
    here = posixpath.dirname(page.file.src_uri)

    def change(link: re.Match[str]) -> str:
        path = posixpath.normpath(posixpath.join(here, link[2]))
        if path == "README.md":
            return f"{link[1]}{posixpath.relpath('docs/index.md', here or '.')}"
        return f"{link[0]}/README.md" if (ROOT / path / "README.md").is_file() else link[0]

    return LINK.sub(change, markdown)


def write_api(folder: Path) -> List[Path]:
    """Write the reference of the public interface of gpr20_analysis; return its files.

    Raises:
        Warning: A docstring or an annotation cannot be shown.
    """
    # pdoc looks for the names of a module in it, where each appears when it is first used.
    for name in gpr20_analysis.__all__:
        setattr(gpr20_analysis, name, getattr(gpr20_analysis, name))
    pdoc.render.configure(docformat="google", show_source=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pdoc.pdoc("gpr20_analysis", r"!gpr20_analysis\.", output_directory=folder)
    return [one for one in folder.rglob("*") if one.is_file() and one.name != "index.html"]


def _outside_pages() -> List[str]:
    readmes = sorted(ROOT.glob("catkin_ws/src/gpr20_*/README.md"))
    packages = [one.relative_to(ROOT).as_posix() for one in readmes]
    return ["CONTRIBUTING.md", "SECURITY.md", *packages]


def _linked_files(page: str, text: str) -> List[str]:
    targets = (posixpath.join(posixpath.dirname(page), link[2]) for link in LINK.finditer(text))
    return [one for one in map(posixpath.normpath, targets) if (ROOT / one).is_file()]


def _interfaces(package: Path) -> str:
    """Return every message, service and action of a package, with its comments, as Markdown."""
    parts = [""]
    for folder, title in KINDS.items():
        parts.append(f"## {title}\n")
        for path in sorted((package / folder).glob(f"*.{folder}")):
            definition = path.read_text(encoding="utf-8").strip()
            parts.append(f"### {path.stem}\n\n```\n{definition}\n```\n")
    return "\n".join(parts)


def messages_markdown() -> str:
    """Return what the site adds to docs/reference/messages.md: a heading for each area."""
    spanish, area, parts = read_catalogue(Language.SPANISH), "", []
    for code, same in itertools.groupby(all_faults(), key=lambda one: one.code):
        if code.split(".")[0] != area:
            area = code.split(".")[0]
            parts.append(f"\n## {area}\n")
        parts.append("- " + "<br>\n  ".join(_lines([*same], spanish)))
    return "\n".join(parts) + "\n"


def all_faults() -> List[Fault]:
    """Return the faults of all packages, in the order of their codes."""
    found = []
    for path in sorted(ROOT.glob("catkin_ws/src/gpr20_*/src/gpr20_*/**/*s.py")):
        if path.name in ("faults.py", "errors.py"):
            place = path.relative_to(ROOT / "catkin_ws/src").with_suffix("").parts[2:]
            module = importlib.import_module(".".join(place))
            found += [one for one in vars(module).values() if isinstance(one, Fault)]
    return sorted(found, key=lambda one: one.code)


def _lines(same: List[Fault], spanish: Catalogue) -> Iterator[str]:
    """Yield what holds for all faults of one code."""
    severities = {one.severity for one in same}
    remarks = [one.value for one in severities - {Severity.FAULT} if len(severities) == 1]
    remarks += ["something may still move"] * all(one.may_move for one in same)
    remarks += ["the survey cannot continue"] * (not any(one.can_continue for one in same))
    yield f"`{same[0].code}`" + (f" ({', '.join(remarks)})" if remarks else "")
    (remedy,) = {one.remedy for one in same}
    if remedy is not None:
        # Remedies that only analysts read are English.
        template = spanish.template(remedy.template)
        yield _markdown(remedy.template)
        if template != remedy.template:
            yield f"*{_markdown(template)}*"


def _markdown(text: str) -> str:
    return re.sub(r"([\\*_\[\]<>`#|])", r"\\\1", " ".join(text.split()))
