"""What a browser wants to see of the ground, checked."""

from __future__ import annotations

import math
import re
from typing import Any, Mapping, NamedTuple, Optional, TypeVar

from gpr20_common.message import Message
from gpr20_operator.ground.grid import Place
from gpr20_operator.ground.sources import MAX_DEPTH_M, Axis, Layer, RadarSettings
from gpr20_operator.palette import Theme
from gpr20_survey.folder.survey_folder import FOLDER_NAME
from gpr20_survey.trace.trace import MAX_COORDINATE
from gpr20_web.errors import BadRequestError

MM_PER_M = 1000.0
MAX_POLARIZATIONS = 64
NUMBER = re.compile(r"-?\d{1,10}(\.\d{1,20})?(e[-+]?\d{1,3})?")
FLAGS = {"0": False, "1": True}
ALONG = {"x": Axis.X_MM, "y": Axis.Y_MM}
THEMES = {one.value: one for one in Theme}
LAYERS = {one.value: one for one in (Layer.COVERAGE, Layer.ECHOES, Layer.FOCUSED)}

Chosen = TypeVar("Chosen")


class GroundChoice(NamedTuple):
    """Everything that a picture depends on, besides the survey; places as in a GroundModel.

    Attributes:
        settings: All but their permittivity, which is that of the survey.
    """

    theme: Theme
    settings: RadarSettings
    place: Optional[Place]


class Values:
    """The fields of a query; each method raises BadRequestError."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._values = values

    def number(self, name: str, low: float, high: float) -> Optional[float]:
        """Return a number between limits; None: there is none."""
        found = self._values.get(name)
        if found is None or found == "":
            return None
        text = str(found)
        number = float(text) if NUMBER.fullmatch(text) else math.nan
        # Written so that NaN is refused too.
        if not low <= number <= high:
            raise _wrong(name, found, Message("{low:g} .. {high:g}", low=low, high=high))
        return number

    def one(self, name: str, choices: Mapping[str, Chosen], preset: Chosen) -> Chosen:
        """Return what a word stands for; the preset if there is none."""
        found = self._values.get(name, "")
        if found == "":
            return preset
        if not isinstance(found, str) or found not in choices:
            raise _wrong(name, found, ", ".join(choices))
        return choices[found]

    @property
    def survey(self) -> str:
        """The folder of a survey; empty: the running one."""
        found = self._values.get("survey", "")
        if not isinstance(found, str) or (found and not FOLDER_NAME.fullmatch(found)):
            raise _wrong("survey", found, "YYYYMMDDTHHMMSS_xxxxxxxx")
        return found

    @property
    def choice(self) -> GroundChoice:
        """What is to be shown."""
        preset = RadarSettings()
        x_mm = self.number("x", -MAX_COORDINATE, MAX_COORDINATE)
        y_mm = self.number("y", -MAX_COORDINATE, MAX_COORDINATE)
        depth_mm = self.number("depth", 0.0, MAX_DEPTH_M * MM_PER_M)
        settings = RadarSettings(
            polarization=int(self.number("polarization", 0, MAX_POLARIZATIONS) or 0),
            depth_m=preset.depth_m if depth_mm is None else depth_mm / MM_PER_M,
            along=self.one("along", ALONG, preset.along),
            layer=self.one("layer", LAYERS, preset.layer),
        )
        return GroundChoice(
            self.one("theme", THEMES, Theme.SUN),
            settings,
            None if x_mm is None or y_mm is None else Place(x_mm, y_mm),
        )


def _wrong(name: str, value: object, allowed: object) -> BadRequestError:
    return BadRequestError(
        Message(
            "{name} cannot be {value}; allowed: {allowed}",
            name=name,
            value=repr(value)[:40],
            allowed=allowed,
        )
    )
