"""Which page of the site each file of the repository is."""

from __future__ import annotations

import posixpath
from pathlib import Path
from typing import Dict

ROOT = Path(__file__).resolve().parents[2]
DOCS = "docs/"
INTERFACES = "catkin_ws/src/gpr20_msgs/README.md"
CHANGELOG = "catkin_ws/src/gpr20/CHANGELOG.rst"
PROJECT_FILES = ("CONTRIBUTING.md", "SECURITY.md")


def outside_pages() -> Dict[str, str]:
    """Return the pages that are not in docs/: path in the repository, and on the site."""
    pages = {name: f"project/{name.lower()}" for name in PROJECT_FILES}
    pages[CHANGELOG] = "project/changelog.md"
    for readme in sorted((ROOT / "catkin_ws/src").glob("gpr20_*/README.md")):
        pages[readme.relative_to(ROOT).as_posix()] = f"packages/{readme.parent.name}.md"
    return pages


def repository_path(page: str, target: str) -> str:
    """Return the path in the repository to which a link of a page leads.

    Args:
        page: Path of the page in the repository.
        target: The link, without its anchor.
    """
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), target))


def site_path(path: str, pages: Dict[str, str]) -> str:
    """Return where the site has a file of the repository.

    Args:
        path: Path in the repository. A folder stands for its README, or that of its package.
        pages: From `outside_pages`.
    """
    if path == "README.md":
        return "index.md"
    if path.startswith(DOCS):
        return path[len(DOCS) :]
    if path in pages:
        return pages[path]
    package = "/".join(path.split("/")[:3])
    for folder in (path, package):
        if (ROOT / path).is_dir() and f"{folder}/README.md" in pages:
            return pages[f"{folder}/README.md"]
    return f"files/{path}"
