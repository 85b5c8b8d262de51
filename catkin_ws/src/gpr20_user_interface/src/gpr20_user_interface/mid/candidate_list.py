"""The candidates of a survey, as `gpr20 candidates --json` prints them."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Any, Dict, List, Mapping, Optional, Tuple

from gpr20_common.errors import InvalidValueError
from gpr20_common.message import Message

FORMAT = "gpr20-candidates/1"
FLAGS: Dict[str, Message] = {
    "surface-residue": Message("surface residue"),
    "edge": Message("edge"),
    "one-polarization": Message("one polarization"),
    "clutter": Message("clutter"),
    "sidelobe": Message("sidelobe"),
    "unrated": Message("not rated"),
}
SECONDARY = (FLAGS["clutter"], FLAGS["sidelobe"])
MOST_SECONDARY = 10


@dataclass(frozen=True)
class ShownCandidate:
    """One candidate.

    Attributes:
        id: Its name in the list.
        x_m: Place along X [m].
        y_m: Place along Y [m].
        depth_m: Depth below the surface [m].
        x_uncertainty_m: Uncertainty along X [m].
        y_uncertainty_m: Uncertainty along Y [m].
        depth_uncertainty_m: Uncertainty of the depth [m].
        above_noise_db: Level above noise [dB]; None if the noise is not known.
        false_alarm_probability: Probability that noise is as bright; None if it is not known.
        flags: What to know before believing it.
    """

    id: str
    x_m: float
    y_m: float
    depth_m: float
    x_uncertainty_m: float
    y_uncertainty_m: float
    depth_uncertainty_m: float
    above_noise_db: Optional[float]
    false_alarm_probability: Optional[float]
    flags: Tuple[Message, ...]

    @property
    def is_secondary(self) -> bool:
        """Whether it may be only clutter, or a sidelobe of a brighter candidate."""
        return any(flag in SECONDARY for flag in self.flags)


@dataclass(frozen=True)
class ShownCandidates:
    """A list of candidates.

    Attributes:
        survey_id: Identifier of the survey.
        simulated: Whether the survey shows no real ground.
        permittivity: Relative permittivity with which depths were computed.
        omitted: Number of candidates that are not in the list.
        omitted_primary: Number of those that are not doubtful.
        candidates: The candidates, the brightest first; doubtful ones come last.
    """

    survey_id: str
    simulated: bool
    permittivity: float
    omitted: int
    omitted_primary: int
    candidates: Tuple[ShownCandidate, ...]

    @property
    def shown(self) -> Tuple[ShownCandidate, ...]:
        """All candidates that are not doubtful, then the brightest doubtful ones."""
        return self.candidates[: self._listed_primary + MOST_SECONDARY]

    @property
    def primary(self) -> int:
        """Number of all candidates that are not doubtful."""
        return self._listed_primary + self.omitted_primary

    @property
    def total(self) -> int:
        """Number of all candidates."""
        return len(self.candidates) + self.omitted

    @property
    def _listed_primary(self) -> int:
        return sum(not one.is_secondary for one in self.candidates)


def candidates_from(text: str, survey_id: str) -> ShownCandidates:
    """Return the candidates that a command printed.

    Args:
        text: What it printed.
        survey_id: The survey that it was asked about.

    Returns:
        The list, in which every value was checked.

    Raises:
        InvalidValueError: Something is missing, or has another type, format or survey.
    """
    try:
        values = json.loads(text)
        _check(isinstance(values, dict) and values["format"] == FORMAT, "format")
        # A list without it is of another kind.
        _check(isinstance(values["warning"], str) and bool(values["warning"]), "warning")
        _check(values["survey_id"] == survey_id, "survey_id")
        _check(isinstance(values["simulated"], bool), "simulated")
        candidates = tuple(_candidate(one) for one in _list(values["candidates"]))
        _check(_count(values["listed"]) == len(candidates), "listed")
        _check(len({one.id for one in candidates}) == len(candidates), "id")
        return ShownCandidates(
            survey_id=survey_id,
            simulated=values["simulated"],
            permittivity=_number(values["permittivity"], 1.0),
            omitted=_count(values["omitted"]),
            omitted_primary=_count(values["omitted_primary"]),
            candidates=candidates,
        )
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        message = Message("the list of candidates is not complete or not valid", details=error)
        raise InvalidValueError(message) from error


def _candidate(values: Mapping[str, Any]) -> ShownCandidate:
    _check(isinstance(values, dict), "candidate")
    _check(isinstance(values["id"], str) and bool(values["id"]), "id")
    flags = _list(values["flags"])
    _check(all(isinstance(one, str) and one in FLAGS for one in flags), "flags")
    level = values["above_noise_db"]
    alarm = values["false_alarm_probability"]
    return ShownCandidate(
        id=values["id"],
        x_m=_number(values["x_m"]),
        y_m=_number(values["y_m"]),
        depth_m=_number(values["depth_m"], 0.0),
        x_uncertainty_m=_number(values["x_uncertainty_m"], 0.0),
        y_uncertainty_m=_number(values["y_uncertainty_m"], 0.0),
        depth_uncertainty_m=_number(values["depth_uncertainty_m"], 0.0),
        above_noise_db=None if level is None else _number(level),
        false_alarm_probability=None if alarm is None else _number(alarm, 0.0, 1.0),
        flags=tuple(FLAGS[one] for one in flags),
    )


def _check(right: bool, name: str) -> None:
    if not right:
        raise ValueError(f"wrong {name}")


def _list(value: object) -> List[Any]:
    if not isinstance(value, list):
        raise ValueError(f"{value!r} is no list")
    return value


def _number(value: object, lowest: float = -math.inf, highest: float = math.inf) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{value!r} is no number")
    # Written so that NaN is refused too.
    if not (math.isfinite(value) and lowest <= value <= highest):
        raise ValueError(f"{value!r} is out of range")
    return float(value)


def _count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"{value!r} is no count")
    return value
