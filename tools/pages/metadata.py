"""Write maintainer, licence and addresses from CITATION.cff to every package.

Usage: .venv/bin/python tools/pages/metadata.py. The keys of CITATION.cff are `contact`, `license`,
and, once the project has them, `repository-code` and `url` (its website).
"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any, Dict
from xml.sax.saxutils import escape, quoteattr

import yaml

ROOT = Path(__file__).resolve().parents[2]


def read_citation(root: Path) -> Dict[str, Any]:
    """Return what CITATION.cff says."""
    citation = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    return dict(citation)


def addresses(citation: Dict[str, Any]) -> Dict[str, str]:
    """Return the addresses of the project by kind; none before CITATION.cff names one."""
    found = {}
    if "url" in citation:
        found["website"] = citation["url"]
    if "repository-code" in citation:
        found["repository"] = citation["repository-code"]
        found["bugtracker"] = citation["repository-code"].rstrip("/") + "/issues"
    return found


def package_xml(text: str, citation: Dict[str, Any]) -> str:
    """Return a package.xml with the maintainer, the licence and the addresses of the project."""
    lines = [
        f"  <maintainer email={quoteattr(one['email'])}>{escape(one['name'])}</maintainer>"
        for one in citation["contact"]
    ]
    lines.append(f"  <license>{escape(citation['license'])}</license>")
    lines += [
        f"  <url type={quoteattr(kind)}>{escape(address)}</url>"
        for kind, address in addresses(citation).items()
    ]
    others = [line for line in text.splitlines() if not _is_metadata(line)]
    end = next(number for number, line in enumerate(others) if "</description>" in line) + 1
    return "\n".join([*others[:end], *lines, *others[end:]]) + "\n"


def pyproject(text: str, citation: Dict[str, Any]) -> str:
    """Return a pyproject.toml with the maintainer, the licence and the addresses of the project."""
    people = ", ".join(
        f'{{ name = "{one["name"]}", email = "{one["email"]}" }}' for one in citation["contact"]
    )
    text = re.sub(r"^maintainers = .*\n", "", text, flags=re.MULTILINE)
    licence = f'license = {{ text = "{citation["license"]}" }}\nmaintainers = [{people}]'
    text = re.sub(r"^license = .*$", licence, text, flags=re.MULTILINE)
    text = re.sub(r"^\[project\.urls\]\n(?:.+\n)*\n", "", text, flags=re.MULTILINE)
    urls = "".join(f'{kind} = "{address}"\n' for kind, address in addresses(citation).items())
    if not urls:
        return text
    first = "[project.optional-dependencies]\n"
    return text.replace(first, f"[project.urls]\n{urls}\n{first}")


def written_files(root: Path) -> Dict[Path, str]:
    """Return the text that each file with metadata should have."""
    citation = read_citation(root)
    packages = root / "catkin_ws/src"
    written = {}
    for path in sorted([*packages.glob("*/package.xml"), *root.glob("ros2/*/package.xml")]):
        written[path] = package_xml(path.read_text(encoding="utf-8"), citation)
    for path in sorted(packages.glob("*/pyproject.toml")):
        written[path] = pyproject(path.read_text(encoding="utf-8"), citation)
    return written


def _is_metadata(line: str) -> bool:
    return line.lstrip().startswith(("<maintainer ", "<license>", "<url "))


if __name__ == "__main__":
    for path, text in written_files(ROOT).items():
        path.write_text(text, encoding="utf-8")
    sys.stdout.write("package.xml and pyproject.toml are those of CITATION.cff\n")
