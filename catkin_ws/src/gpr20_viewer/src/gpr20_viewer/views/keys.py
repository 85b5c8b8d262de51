"""The keys of the viewer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

from gpr20_common.message import Message


@dataclass(frozen=True)
class Key:
    """Keys that do one thing.

    Attributes:
        action: Name of the action.
        keys: Key sequences, as Qt names them.
        shown: How they are named in the list of keys.
        effect: What they do.
    """

    action: str
    keys: Sequence[str]
    shown: str
    effect: Message


KEYS = (
    Key("left", ("Left",), "←", Message("cursor to smaller x")),
    Key("right", ("Right",), "→", Message("cursor to larger x")),
    Key("up", ("Up",), "↑", Message("cursor to larger y")),
    Key("down", ("Down",), "↓", Message("cursor to smaller y")),
    Key("shallower", ("PgUp",), "PgUp", Message("cursor and slice upwards")),
    Key("deeper", ("PgDown",), "PgDn", Message("cursor and slice downwards")),
    Key("more", ("+", "="), "+", Message("larger permittivity")),
    Key("less", ("-",), "-", Message("smaller permittivity")),
    Key("pick", ("P",), "P", Message("pick the place of the cursor")),
    Key("mode", ("C",), "C", Message("switch on or off that a click picks")),
    Key("undo", ("Ctrl+Z",), "Ctrl+Z", Message("undo the last change of the picks")),
    Key("redo", ("Ctrl+Shift+Z", "Ctrl+Y"), "Ctrl+Y", Message("redo the undone change")),
    Key("delete", ("Del",), "Del", Message("delete the selected pick")),
    Key("polarization", ("R",), "R", Message("next polarization")),
    Key("direction", ("L",), "L", Message("section along the other axis")),
    Key("background", ("B",), "B", Message("background on or off")),
    Key("all", ("F",), "F", Message("show the whole pictures again")),
)
