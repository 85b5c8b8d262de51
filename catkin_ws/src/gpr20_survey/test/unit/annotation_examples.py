"""Annotations for tests: good ones of every kind, and texts and positions that are refused."""

from __future__ import annotations

from hypothesis import strategies as st

from gpr20_survey.plan.annotation import Annotation, Wgs84Position

EXAMPLE = Annotation(
    "Lucía Peña",
    "Vereda El Carmen, parcela 3",
    "Suelo húmedo.\nEstaca norte = origen.",
    Wgs84Position(4.60283, -74.06514),
    name="El Carmen 3",
)

# All characters that can be shown: neither controls, halves of characters nor separators of lines.
_SHOWN = st.characters(
    blacklist_categories=("Cc", "Cs", "Zl", "Zp"),
    blacklist_characters="\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069",
)
names = st.text(_SHOWN, max_size=200)
notes = st.text(st.one_of(_SHOWN, st.just("\n")), max_size=4000)
positions = st.builds(Wgs84Position, st.floats(-90.0, 90.0), st.floats(-180.0, 180.0))
annotations = st.builds(
    Annotation, names, names, notes, st.one_of(st.none(), positions), name=names
)

REFUSED = (
    ({"operator": "a" * 201}, "operator has 201 characters; at most 200 are allowed"),
    ({"name": "a" * 201}, "name has 201 characters"),
    ({"site": "a" * 201}, "site has 201 characters"),
    ({"notes": "a" * 4001}, "notes has 4001 characters; at most 4000"),
    ({"operator": "a\nb"}, "operator holds U\\+000A at character 2, which cannot be shown"),
    ({"name": "a\nb"}, "name holds U\\+000A"),
    ({"site": "\x1b[2J"}, "site holds U\\+001B at character 1"),
    ({"notes": "a\rb"}, "notes holds U\\+000D"),
    ({"notes": "half \ud83d"}, "notes holds U\\+D83D"),
    ({"operator": "reversed \u202egpj.exe"}, "operator holds U\\+202E"),
    ({"site": 5}, "site is of type int; it must be a text"),
    ({"notes": None}, "notes is of type NoneType"),
)
REFUSED_POSITIONS = (
    ((90.001, 0.0), "latitude is 90.001 deg; it must lie between -90 and 90 deg"),
    ((-91.0, 0.0), "latitude is -91 deg"),
    ((0.0, 180.5), "longitude is 180.5 deg; it must lie between -180 and 180 deg"),
    ((float("nan"), 0.0), "latitude is nan deg"),
    ((0.0, float("inf")), "longitude is inf deg"),
    ((10**400, 0.0), "latitude is inf deg"),
    (("4.6", 0.0), "latitude is of type str; it must be a number"),
    ((True, 0.0), "latitude is of type bool"),
    ((0.0, None), "longitude is of type NoneType"),
)
