"""The frames of the robot as a picture, from the diagram of docs/ros.md."""

from __future__ import annotations

import re
from typing import Dict, Tuple

from pictures.svg import Picture

SIZE = (138.0, 32.0)
COLUMN, ROW, MARGIN = 216.0, 58.0, 8.0
JOINT = re.compile(r"(\w+) -->\|(\w+)\| (\w+)")


def frames_picture(diagram: str) -> str:
    """Return the picture as SVG.

    Args:
        diagram: The Mermaid text of the frames, a line for each joint, parents first.
    """
    joints = JOINT.findall(diagram)
    places: Dict[str, Tuple[int, int]] = {joints[0][0]: (0, 0)}
    for parent, _joint, child in joints:
        column, row = places[parent][0] + 1, places[parent][1]
        while (column, row) in places.values():
            row += 1
        places[child] = (column, row)
    columns, rows = (1 + max(place[axis] for place in places.values()) for axis in (0, 1))
    width = MARGIN * 2 + COLUMN * (columns - 1) + SIZE[0]
    picture = Picture(width, MARGIN * 2 + ROW * (rows - 1) + SIZE[1], "Frames of the robot")
    corners = {
        frame: (MARGIN + column * COLUMN, MARGIN + row * ROW)
        for frame, (column, row) in places.items()
    }
    for parent, joint, child in joints:
        start = (corners[parent][0] + SIZE[0], corners[parent][1] + SIZE[1] / 2)
        end = (corners[child][0], corners[child][1] + SIZE[1] / 2)
        turn = start[0] + 12
        picture.arrow([start, (turn, start[1]), (turn, end[1]), end])
        picture.words(((turn + end[0]) / 2, end[1] - 8), joint, "small", "middle")
    for frame, (x, y) in corners.items():
        picture.box((x, y), SIZE, "box")
        picture.words((x + SIZE[0] / 2, y + 20), frame, "mono", "middle")
    return picture.text
