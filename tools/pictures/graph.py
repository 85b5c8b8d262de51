"""The ROS graph as a picture, from the table of docs/reference/ros_graph.md."""

from __future__ import annotations

import re
from typing import Dict, List, Tuple

from pictures.svg import Picture

WIDTH = 250.0
GAP = 28.0
LINE = 15.5
COLUMNS = 4
HEAD = 26.0
AXIS = "<axis>_axis/axis_driver"
# Where the nodes of a robot run, from left to right. Every other node is beside the robot.
MACHINES = {
    "PC: measures, stores, controls": [
        "vna_acquisition",
        "main_control",
        "vna_processing",
        "imaging",
    ],
    "Robot: moves, measures the height, shows": ["height_sensor", AXIS, "user_interface"],
}
EVERY_NODE = "every node"
BESIDE = "Beside the robot"
COMMON = "On all of these nodes"
# Client and node: who calls whom.
CALLS = [
    ("main_control", "vna_acquisition"),
    ("main_control", "vna_processing"),
    ("main_control", "height_sensor"),
    ("main_control", AXIS),
    ("user_interface", "main_control"),
    ("user_interface", "vna_processing"),
    ("user_interface", "imaging"),
]
Interface = Tuple[str, str]


def nodes_of(page: str) -> Dict[str, List[Interface]]:
    """Return the interfaces of each node, with their kinds.

    Args:
        page: The page with the table.
    """
    table = page.split("| node | interface | kind |")[1].split("\n\n")[0]
    nodes: Dict[str, List[Interface]] = {}
    name = ""
    for row in table.splitlines()[2:]:
        first, interfaces, kind = row.strip().strip("|").split("|")
        # A cell such as "for x, y, z" explains the node above.
        if first.strip() and not first.strip().startswith("for "):
            name = ", ".join(re.findall(r"`([^`]+)`", first)) or EVERY_NODE
            nodes.setdefault(name, [])
        for one in re.findall(r"`([^`]+)`", interfaces):
            nodes[name].append((one.replace("<axis>_axis/", ""), _kind(kind)))
    return nodes


def _kind(words: str) -> str:
    for kind in ("action", "service", "topic"):
        if kind in words:
            return kind
    return ""


def graph_picture(page: str) -> str:
    """Return the picture as SVG.

    Args:
        page: The page with the table.
    """
    nodes = nodes_of(page)
    placed = {name for row in MACHINES.values() for name in row}
    # As a client the window shares a row of the table with the terminal client.
    placed.add(EVERY_NODE)
    beside = [name for name in nodes if name not in placed and "user_interface" not in name]
    chunks = [beside[at : at + COLUMNS] for at in range(0, len(beside), COLUMNS)]
    rows = [*MACHINES.items(), *((BESIDE, chunk) for chunk in chunks), (COMMON, [EVERY_NODE])]
    width = GAP + COLUMNS * (WIDTH + GAP) + GAP
    heights = [max(_height(nodes.get(name, [])) for name in row) for _title, row in rows]
    total = sum(heights) + len(rows) * (HEAD + 3 * GAP)
    picture = Picture(width, total, "Nodes of the ROS graph, their interfaces and who calls whom")
    corners: Dict[str, Tuple[float, float]] = {}
    bottoms: Dict[str, float] = {}
    top = GAP / 2
    for (title, row), height in zip(rows, heights):
        picture.box((GAP / 2, top), (width - GAP, height + HEAD + GAP), "band")
        picture.words((width - GAP, top + 20), title, "title", "end")
        for column, name in enumerate(row):
            corners[name] = (GAP + column * (WIDTH + GAP) + GAP / 2, top + HEAD + 8)
            bottoms[name] = corners[name][1] + _height(nodes.get(name, []))
            _draw(picture, corners[name], name, nodes.get(name, []), title in (BESIDE, COMMON))
        top += height + HEAD + 2 * GAP + 14
    for client, server in CALLS:
        _call(picture, corners, bottoms, client, server)
    picture.words((GAP, top + 4), "Arrow: from the client to the node that it calls.", "small")
    return picture.text


def _height(interfaces: List[Interface]) -> float:
    return HEAD + LINE * max(len(interfaces), 2) + 10


def _draw(
    picture: Picture,
    corner: Tuple[float, float],
    name: str,
    interfaces: List[Interface],
    other: bool,
) -> None:
    x, y = corner
    size = (WIDTH, _height(interfaces))
    copies = 3 if name == AXIS else 1
    for copy in reversed(range(copies)):
        picture.box((x + 5 * copy, y + 5 * copy), size, "other" if other else "box")
    title = "x, y, z: <axis>_axis/axis_driver" if name == AXIS else name
    picture.words((x + 10, y + 19), title, "mono title" if len(title) < 24 else "mono")
    for number, (words, kind) in enumerate(interfaces):
        line = y + HEAD + LINE * (number + 1)
        picture.words((x + 10, line), words, "mono")
        picture.words((x + WIDTH - 10, line), kind, "small", "end")


def _call(
    picture: Picture,
    corners: Dict[str, Tuple[float, float]],
    bottoms: Dict[str, float],
    client: str,
    server: str,
) -> None:
    """Draw who calls whom: within a row from side to side, else through the gap between rows."""
    (x1, y1), (x2, y2) = corners[client], corners[server]
    if y1 == y2:
        side = (WIDTH, 0.0) if x2 > x1 else (0.0, WIDTH)
        picture.arrow([(x1 + side[0], y1 + 40), (x2 + side[1], y2 + 40)])
        return
    # Side by side where several lines leave one box.
    shift = (x2 - x1) / 8
    start, end = x1 + WIDTH / 2 + shift, x2 + WIDTH / 2 - shift
    # A line turns between the two rows.
    lower = max(y1, y2)
    turn = lower - HEAD - 8 - GAP / 2 - abs(shift) / 12
    ends = (bottoms[client], lower) if y1 < y2 else (lower, bottoms[server])
    picture.arrow([(start, ends[0]), (start, turn), (end, turn), (end, ends[1])])
