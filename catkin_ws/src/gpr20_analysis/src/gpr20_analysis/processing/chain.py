"""Steps, also those of installed packages, and chains of them: from text, applied, and recorded.

An installed package offers steps as entry points of the group `gpr20_analysis.steps`. Only these
and the steps of this package can be named: a name never makes anything be imported that was not
installed.
"""

from __future__ import annotations

import enum
import inspect
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple, Type, Union, get_type_hints

import xarray as xr

from gpr20_analysis import errors
from gpr20_analysis.dataset import PROCESSING, QUALITY, SAMPLE_DIMS, SIMULATED
from gpr20_analysis.entry_points import ExtensionPoint
from gpr20_analysis.errors import AnalysisError, StepError
from gpr20_analysis.processing.antenna_step import without_antenna
from gpr20_analysis.processing.background import remove_background, subtract_coupling
from gpr20_analysis.processing.delay import set_time_zero, to_time
from gpr20_analysis.processing.surface_echo import with_surface_delay
from gpr20_analysis.processing.sweep import (
    select_band,
    select_polarization,
)
from gpr20_analysis.read.load import load_survey
from gpr20_common.message import Message

PARAMETER_TYPES = "int, float, str, an Enum or xarray.Dataset"

FUNCTIONS: Dict[str, Callable[..., xr.Dataset]] = {
    "antenna": without_antenna,
    "coupling": subtract_coupling,
    "background": remove_background,
    "band": select_band,
    "time_zero": set_time_zero,
    "polarization": select_polarization,
    "time": to_time,
}
"""The steps by name; the arguments after the survey are the parameters of a step."""


@dataclass(frozen=True)
class StepFunction:
    """The function of a step.

    Attributes:
        name: How the command line names it.
        call: The function: Dataset and parameters to Dataset.
        origin: Package, version and object; empty for a step of this package.
    """

    name: str
    call: Callable[..., xr.Dataset]
    origin: str = ""

    @property
    def parameters(self) -> Dict[str, Tuple[Any, Any]]:
        """(Type, default) of each parameter."""
        hints = get_type_hints(self.call)
        parameters = list(inspect.signature(self.call).parameters.values())[1:]
        return {one.name: (hints.get(one.name), one.default) for one in parameters}

    def apply(self, survey: xr.Dataset, **arguments: Any) -> xr.Dataset:
        """Return the Dataset after the step; attributes that a foreign step drops are kept.

        Raises:
            AnalysisError: The step cannot be applied, failed, or made no Dataset of this survey.
        """
        if not self.origin:
            return self.call(survey, **arguments)
        try:
            result = self.call(survey, **arguments)
        except AnalysisError:
            raise
        except Exception as error:  # the function is not ours: it may raise anything
            raise self.unusable(f"{type(error).__name__}: {error}") from error
        if not isinstance(result, xr.Dataset):
            raise self.unusable(
                Message("it returned {type}, no xarray.Dataset", type=type(result).__name__)
            )
        lost = [
            name
            for name in (*SAMPLE_DIMS, QUALITY)
            if name in survey and not (name in result and result[name].equals(survey[name]))
        ]
        lost += [
            str(name)
            for name, data in survey.data_vars.items()
            if name in result and set(result[name].dims) != set(data.dims)
        ]
        if lost:
            names = ", ".join(lost)
            raise self.unusable(
                Message("it changed {names}; positions, flags and dimensions stay", names=names)
            )
        # Whatever a step does: data stay simulated, and recorded as made by the steps before it.
        kept = {key: survey.attrs[key] for key in (SIMULATED, PROCESSING) if key in survey.attrs}
        return result.assign_attrs({**survey.attrs, **result.attrs, **kept})

    def unusable(self, reason: Union[str, Message]) -> StepError:
        """Return the error of a step that is not of this package."""
        return StepError(
            Message(
                "step '{step}' ({origin}) cannot be used: {reason}",
                step=self.name,
                origin=self.origin,
                reason=reason,
            ),
            fault=errors.STEPS,
        )


STEPS = ExtensionPoint(
    "gpr20_analysis.steps",
    Message("the step"),
    own={name: StepFunction(name, call) for name, call in FUNCTIONS.items()},
    error=StepError,
    fault=errors.STEPS,
)
"""By this, other packages add steps."""


def find_step(name: str) -> StepFunction:
    """Return the function of a step.

    Raises:
        StepError: There is none, or its package cannot be used.
    """
    if name in STEPS.own:
        own: StepFunction = STEPS.own[name]
        return own
    added = STEPS.addition(name)
    found = StepFunction(name, STEPS.load(added), added.origin)
    if not callable(found.call):
        raise found.unusable(Message("it is not a function"))
    for key, (kind, _default) in found.parameters.items():
        is_enum = inspect.isclass(kind) and issubclass(kind, enum.Enum)
        if kind not in (int, float, str, xr.Dataset) and not is_enum:
            raise found.unusable(
                Message(
                    "parameter '{parameter}' must be annotated with one of: {allowed}",
                    parameter=key,
                    allowed=PARAMETER_TYPES,
                )
            )
    return found


Reader = Callable[[str], xr.Dataset]

ORIGIN = "origin"
"""Key of a recorded step: where its function comes from, if not from this package."""


@dataclass(frozen=True)
class Step:
    """One step of a chain.

    Attributes:
        function: Its function.
        parameters: Values by name, numbers and texts. A Dataset is given as its path.
    """

    function: StepFunction
    parameters: Mapping[str, Any]

    @property
    def name(self) -> str:
        """How the command line names it."""
        return self.function.name

    def recorded(self) -> Dict[str, Any]:
        """Return the step as attribute `processing` lists it."""
        origin = {ORIGIN: self.function.origin} if self.function.origin else {}
        return {"step": self.name, **origin, **self.parameters}


def step_from_text(text: str) -> Step:
    """Return the step of a text such as `background:method=moving,width=5`.

    Raises:
        StepError: It is malformed, or a step or parameter is unknown.
    """
    name, _, rest = text.partition(":")
    parameters: Dict[str, Any] = {}
    for item in rest.split(",") if rest else []:
        key, equals, value = item.partition("=")
        if not equals or key.strip() in parameters:
            raise StepError(
                Message(
                    "'{item}' in step '{step}' must be written as parameter=value, each only once",
                    item=item,
                    step=text,
                )
            )
        parameters[key.strip()] = value.strip()
    return checked(name.strip(), parameters)


def checked(name: str, parameters: Mapping[str, Any]) -> Step:
    """Return a step after a check of its name and parameters.

    Args:
        name: Name of the step, of this package or of an installed one.
        parameters: Values by name, as texts or numbers.

    Raises:
        StepError: The step or a parameter is unknown, or a value has the wrong type.
    """
    function = find_step(name)
    known = function.parameters
    for key in parameters:
        if key not in known:
            raise StepError(
                Message(
                    "step '{step}' has no parameter '{parameter}'; its parameters are: {known}",
                    step=name,
                    parameter=key,
                    known=", ".join(known) or "-",
                )
            )
    values = {}
    for key, (kind, default) in known.items():
        value = parameters.get(key, default)
        if value is inspect.Parameter.empty:
            raise StepError(
                Message("step '{step}' needs the parameter '{parameter}'", step=name, parameter=key)
            )
        values[key] = _plain(name, key, kind, value)
    return Step(function, values)


def text_of(recorded: Mapping[str, Any]) -> str:
    """Return a recorded step as `--step` takes it, which repeats it."""
    values = [f"{key}={value}" for key, value in recorded.items() if key not in ("step", ORIGIN)]
    return ":".join([str(recorded["step"]), *([",".join(values)] if values else [])])


def apply_steps(survey: xr.Dataset, steps: Sequence[Step], read: Reader) -> xr.Dataset:
    """Apply steps one after another; attribute `processing` of the result lists all of them.

    Before the first one the surface echo is looked for, because many steps remove it; an image
    compares it with the recorded heights (attribute `surface_delay_s`).

    Args:
        survey: The survey.
        steps: The steps.
        read: Reads a Dataset that a step names, such as a reference survey.
    """
    if steps and not recorded_steps(survey):
        survey = with_surface_delay(survey)
    for step in steps:
        arguments = {
            key: read(step.parameters[key]) if kind is xr.Dataset else kind(step.parameters[key])
            for key, (kind, _) in step.function.parameters.items()
        }
        recorded = recorded_steps(survey) + [step.recorded()]
        survey = step.function.apply(survey, **arguments)
        survey = survey.assign_attrs({PROCESSING: json.dumps(recorded)})
    return survey


def process_survey(survey: xr.Dataset, *steps: str) -> xr.Dataset:
    """Apply steps given as text, such as "background:method=moving,width=5", one after another.

    Args:
        survey: Dataset of a survey, or of an earlier step.
        steps: The steps, as for `--step` of the command line.

    Returns:
        The Dataset after the steps; attribute `processing` lists what made it.

    Raises:
        StepError: One is malformed, or a step or parameter is unknown.
        AnalysisError: A step cannot be applied to the survey.
    """
    return apply_steps(survey, [step_from_text(step) for step in steps], load_survey)


def recorded_steps(data: xr.Dataset) -> List[Dict[str, Any]]:
    """Return the steps by which a Dataset was made, as recorded; empty for data as measured."""
    recorded: List[Dict[str, Any]] = json.loads(data.attrs.get(PROCESSING, "[]"))
    return recorded


def _plain(step: str, key: str, kind: Type[Any], value: Any) -> Any:
    """Return a value as number or text, after a check that it suits the type of the argument."""
    try:
        if kind is xr.Dataset:
            return str(Path(str(value)).resolve())
        if issubclass(kind, enum.Enum):
            return kind(value).value
        if kind is str:
            return str(value)
        number = float(value)
        if not math.isfinite(number) or (kind is int and number != int(number)):
            raise ValueError("not finite, or not whole")
        return kind(number)
    except (TypeError, ValueError) as error:
        is_choice = issubclass(kind, enum.Enum)
        allowed = ", ".join(one.value for one in kind) if is_choice else kind.__name__
        raise StepError(
            Message(
                "parameter '{parameter}' of step '{step}' is {value}; allowed: {allowed}",
                parameter=key,
                step=step,
                value=repr(value),
                allowed=allowed,
            )
        ) from error
