"""Annotations for tests: good ones of every kind, and texts and positions that are refused."""

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
    ({"operator": "a" * 201}, ("operator", 201, 200)),
    ({"notes": "a" * 4001}, ("notes", 4001, 4000)),
    ({"operator": "a\nb"}, ("operator", "U+000A", 2)),
    ({"site": "\x1b[2J"}, ("site", "U+001B", 1)),
    ({"notes": "half \ud83d"}, ("notes", "U+D83D")),
    ({"operator": "reversed \u202egpj.exe"}, ("operator", "U+202E")),
    *(({"heading_deg": wrong}, ()) for wrong in (-0.1, 360.1, float("nan"))),
)
REFUSED_POSITIONS = (
    ((90.001, 0.0), ("latitude", 90.001, -90, 90, "deg")),
    ((0.0, 180.5), ("longitude", 180.5, -180, 180, "deg")),
    ((float("nan"), 0.0), ("latitude", "nan")),
    ((10**400, 0.0), ("latitude", "inf")),
)
