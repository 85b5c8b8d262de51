"""Lists of candidates for tests of all packages."""

from hypothesis import strategies as st

from gpr20_common.message import Fault, Message
from gpr20_survey.results.candidates import AreaPosition, Candidate, CandidateList, Flag

SURVEY = "5ec1a5d2-0000-4000-8000-000000000000"
NOTE = Message("{count} places are not sure", count=3).with_fault(Fault("zeros.unproven"))


def candidate(number=1, x_mm=150.0, y_mm=90.0, depth_mm=60.0, level_db=31.0, flags=(), **changes):
    values = {
        "id": f"C{number:02d}",
        "x_m": x_mm / 1e3,
        "y_m": y_mm / 1e3,
        "depth_m": depth_mm / 1e3,
        "x_uncertainty_m": 0.004,
        "y_uncertainty_m": 0.004,
        "depth_uncertainty_m": 0.006,
        "above_clutter_db": level_db,
        "rotations_deg": (0.0, 90.0),
        "polarization_ratio_db": -0.1,
        "flags": tuple(flags),
    }
    return Candidate(**{**values, **changes})


def candidate_list(candidates=(), **changes):
    values = {
        "survey_id": SURVEY,
        "simulated": True,
        "method": "phase-shift",
        "permittivity": 4.0,
        "permittivity_lowest": 3.5,
        "permittivity_highest": 4.5,
        "permittivity_source": "",
        "area_m2": 0.25,
        "false_alarms_per_m2": 10.0,
        "least_db": 11.5,
        "omitted": 0,
        "position": None,
        "candidates": tuple(candidates),
    }
    return CandidateList(**{**values, **changes})


def numbers(lowest=-1e6, highest=1e6):
    return st.floats(lowest, highest, allow_nan=False)


SIZES = numbers(0.0, 10.0)
CANDIDATES = st.builds(
    Candidate,
    id=st.just(""),
    x_m=numbers(-10.0, 10.0),
    y_m=numbers(-10.0, 10.0),
    depth_m=SIZES,
    x_uncertainty_m=SIZES,
    y_uncertainty_m=SIZES,
    depth_uncertainty_m=SIZES,
    above_clutter_db=numbers(-1e3, 1e3),
    rotations_deg=st.lists(numbers(), max_size=3).map(tuple),
    polarization_ratio_db=st.none() | numbers(),
    flags=st.lists(st.sampled_from(Flag), unique=True).map(tuple),
)
POSITIONS = st.builds(
    AreaPosition, numbers(-80.0, 80.0), numbers(-179.0, 179.0), numbers(0.0, 360.0)
)
ANYWHERE = st.none() | POSITIONS
WORDS = st.text(st.characters(blacklist_categories=["Cs", "Cc"]), max_size=9)


@st.composite
def candidate_lists(draw):
    """Draw a list as the analysis makes it: numbered, those below the cut last."""
    found = sorted(draw(st.lists(CANDIDATES, max_size=25)), key=lambda one: one.is_doubtful)
    return CandidateList(
        survey_id=draw(WORDS),
        simulated=draw(st.booleans()),
        method=draw(WORDS),
        permittivity=draw(numbers(1.0, 100.0)),
        permittivity_lowest=draw(numbers(1.0, 100.0)),
        permittivity_highest=draw(numbers(1.0, 100.0)),
        area_m2=draw(SIZES),
        false_alarms_per_m2=draw(numbers(0.0)),
        least_db=draw(numbers(-100.0, 100.0)),
        omitted=draw(st.integers(0, 1000)),
        candidates=tuple(
            Candidate(**{**vars(one), "id": f"C{number:02d}"})
            for number, one in enumerate(found, 1)
        ),
        notes=(NOTE,) * draw(st.integers(0, 3)),
        position=draw(ANYWHERE),
        permittivity_source=draw(WORDS),
    )
