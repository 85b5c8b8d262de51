"""The annotation that the next survey will start with."""

from __future__ import annotations

from dataclasses import replace

from gpr20_survey.plan.annotation import EMPTY, Annotation


class NextAnnotation:
    """Operator and site stay for the surveys that follow; name, notes and position are for one.

    Attributes:
        value: The annotation.
    """

    def __init__(self) -> None:
        self.value = EMPTY

    def take_defaults(self, defaults: Annotation) -> None:
        """Fill the empty fields with those of the robot."""
        self.value = self.value.with_defaults(defaults)

    def note_started(self) -> None:
        """Note that a survey has started with this annotation."""
        self.value = replace(self.value, name="", notes="", position=None)
