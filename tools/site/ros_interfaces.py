"""The page of the ROS interfaces: every message, service and action with its comments."""

from __future__ import annotations

from pathlib import Path

KINDS = {"msg": "Messages", "srv": "Services", "action": "Actions"}


def interfaces_markdown(package: Path) -> str:
    """Return the definitions of a package of interfaces as Markdown.

    Args:
        package: The folder of the package, with `msg`, `srv` and `action`.
    """
    parts = []
    for folder, title in KINDS.items():
        parts.append(f"## {title}\n")
        for path in sorted((package / folder).glob(f"*.{folder}")):
            definition = path.read_text(encoding="utf-8").strip()
            parts.append(f"### {path.stem}\n\n```\n{definition}\n```\n")
    return "\n".join(parts)
