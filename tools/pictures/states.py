"""The states of a survey as a picture, from the table of transitions."""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

from pictures.svg import Picture

SIZE = (118.0, 36.0)
# Column and row of each state.
PLACES: Dict[str, Tuple[float, float]] = {
    "IDLE": (0, 0),
    "CONFIGURED": (1, 0),
    "CHECKING": (2, 0),
    "HOMING": (3, 0),
    "SURVEYING": (4, 0),
    "FINISHED": (5, 0),
    "PAUSED": (2.8, 1),
    "PAUSING": (4, 1),
    "STOPPING": (3.4, 2),
    "STOPPED": (1.2, 2),
    "FAILED": (5, 2),
}
COLUMN, ROW, MARGIN = 178.0, 130.0, 64.0


def states_picture(diagram: str) -> str:
    """Return the picture as SVG.

    Args:
        diagram: The Mermaid text of the states, a line for each transition.
    """
    transitions = _transitions(diagram)
    width = MARGIN * 2 + COLUMN * 5 + SIZE[0]
    picture = Picture(width, MARGIN * 2 + ROW * 2 + SIZE[1] + 26, "States of a survey")
    # The pale ones first, so that the others are on top of them.
    for pale in (True, False):
        for before, after in transitions:
            if before != after and (after in ("FAILED", "STOPPING") or _is_over(before)) == pale:
                _draw(picture, before, after, "thin" if pale else "arrow")
    for state in PLACES:
        x, y = _centre(state)
        picture.box((x - SIZE[0] / 2, y - SIZE[1] / 2), SIZE, "box")
        picture.words((x, y + 5), state, "mono title", "middle")
    note = "Pale: stop_survey, a software fault, and a survey after the one that ended."
    picture.words((MARGIN, MARGIN * 2 + ROW * 2 + SIZE[1]), note, "small")
    return picture.text


def _transitions(diagram: str) -> List[Tuple[str, str]]:
    lines = [line.split(":")[0].split("-->") for line in diagram.splitlines() if "-->" in line]
    return [(before.strip(), after.strip()) for before, after in lines]


def _is_over(state: str) -> bool:
    return state in ("FINISHED", "STOPPED", "FAILED")


def _centre(state: str) -> Tuple[float, float]:
    column, row = PLACES[state]
    return MARGIN + SIZE[0] / 2 + column * COLUMN, MARGIN + SIZE[1] / 2 + row * ROW


def _edge(state: str, towards: Tuple[float, float]) -> Tuple[float, float]:
    """Return where a line from the centre of a state leaves its box."""
    x, y = _centre(state)
    along, down = towards[0] - x, towards[1] - y
    scale = min(
        SIZE[0] / 2 / abs(along) if along else math.inf,
        SIZE[1] / 2 / abs(down) if down else math.inf,
    )
    return x + along * scale, y + down * scale


def _draw(picture: Picture, before: str, after: str, style: str) -> None:
    start, end = _centre(before), _centre(after)
    length = math.hypot(end[0] - start[0], end[1] - start[1])
    # Bent to its left, so that the two directions are beside each other.
    bend = 14 + 0.16 * max(length - COLUMN, 0)
    middle = (
        (start[0] + end[0]) / 2 + (end[1] - start[1]) / length * bend,
        (start[1] + end[1]) / 2 - (end[0] - start[0]) / length * bend,
    )
    picture.curve(_edge(before, middle), middle, _edge(after, middle), style)
