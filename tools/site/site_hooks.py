"""What MkDocs calls while it builds the site (mkdocs.yml): pages from outside docs/, links."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path
from typing import Any, Dict, Set

import api_reference
from messages_page import messages_markdown
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from ros_interfaces import interfaces_markdown
from site_files import (
    CHANGELOG,
    DOCS,
    INTERFACES,
    ROOT,
    outside_pages,
    repository_path,
    site_path,
)
from site_markdown import (
    changelog_markdown,
    heading_anchor,
    indent_lists,
    relative_link,
    rewrite_links,
)

# By the first word of their Mermaid text, which needs a network.
DIAGRAMS = {
    "stateDiagram-v2": "![States of a survey](images/states.svg)",
    "graph": "![Frames of the robot](images/frames.svg)",
}
API = '\n<a href="../api/gpr20_analysis.html">The complete reference</a>\n'
# A drawing with small words can be opened alone.
DRAWING = re.compile(r"^(!\[[^\]]*\]\((\S+\.svg)\))$", re.MULTILINE)
PAGES = outside_pages()
SOURCES = {site: source for source, site in PAGES.items()}


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Give headings the anchors that they have on GitHub, and list the packages."""
    toc: Dict[str, Any] = config.mdx_configs.setdefault("toc", {})
    toc["slugify"] = heading_anchor
    packages = [page for page in PAGES.values() if page.startswith("packages/")]
    listed = [page for page in packages if page != PAGES[INTERFACES]]
    config.nav = [*config.nav[:-1], {"Packages": listed}, *config.nav[-1:]]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that are not in docs/, the files that pages link to, and the Python API."""
    for source, site in PAGES.items():
        files.append(File.generated(config, site, content=_outside_page(source)))
    for path in sorted(_linked_files(files)):
        added = File.generated(config, f"files/{path}", abs_src_path=str(ROOT / path))
        files.append(added)
    with tempfile.TemporaryDirectory() as folder:
        for page in api_reference.build(Path(folder)).parent.rglob("*"):
            if page.is_file() and page.name != "index.html":
                name = page.relative_to(folder).as_posix()
                files.append(File.generated(config, f"api/{name}", content=page.read_bytes()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Return the Markdown of a page as MkDocs reads it, with links to where the pages are."""
    here = page.file.src_uri
    source = _source(here)
    if here == "reference/api.md":
        markdown += API
    if here == "reference/messages.md":
        markdown += messages_markdown()

    def change(target: str) -> str:
        name, _hash, anchor = target.partition("#")
        site = site_path(repository_path(source, name), PAGES)
        if files.get_file_from_path(site) is None:
            raise PluginError(f"{source} links to {target}, which is not on the site")
        return relative_link(here, site, anchor)

    drawn = DRAWING.sub(r"[\1](\2)", _without_mermaid(markdown))
    return indent_lists(rewrite_links(drawn, change))


def _without_mermaid(markdown: str) -> str:
    """Return the text with pictures instead of diagrams."""
    fence = re.compile(r"^```mermaid\n(\S+).*?^```$", re.DOTALL | re.MULTILINE)
    return fence.sub(lambda found: DIAGRAMS[found[1]], markdown)


def _outside_page(source: str) -> str:
    text = (ROOT / source).read_text(encoding="utf-8")
    if source == CHANGELOG:
        return changelog_markdown(text)
    if source == INTERFACES:
        text += "\n" + interfaces_markdown((ROOT / source).parent)
    return text


def _source(site: str) -> str:
    return SOURCES.get(site, DOCS + site)


def _linked_files(files: Files) -> Set[str]:
    """Return the files of the repository that pages link to and that are no pages."""
    found: Set[str] = set()
    for file in files.documentation_pages():
        source = _source(file.src_uri)

        def note(target: str, source: str = source) -> str:
            path = repository_path(source, target.partition("#")[0])
            site = site_path(path, PAGES)
            if site.startswith("files/") and (ROOT / path).is_file():
                found.add(path)
            return target

        rewrite_links(file.content_string, note)
    return found
