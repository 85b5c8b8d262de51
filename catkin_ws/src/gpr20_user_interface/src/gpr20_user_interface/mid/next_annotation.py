"""The annotation that the next survey will start with."""

from __future__ import annotations

from dataclasses import replace

from gpr20_survey.plan.annotation import EMPTY, Annotation
from gpr20_user_interface.mid.next_name import first_name, next_name


class NextAnnotation:
    """Operator and site stay for the surveys that follow, and their names are numbered.

    Notes and position are for one survey.

    Attributes:
        value: The annotation.
    """

    def __init__(self) -> None:
        self.value = EMPTY

    def take_defaults(self, defaults: Annotation) -> None:
        """Fill the empty fields with those of the robot."""
        self.take(self.value.with_defaults(defaults))

    def take(self, annotation: Annotation) -> None:
        """Take over what the operator wrote, with a name if site is new and the name is not."""
        former, self.value = self.value, annotation
        if annotation.site != former.site and annotation.name in ("", first_name(former.site)):
            self.value = replace(annotation, name=first_name(annotation.site))

    def note_started(self) -> None:
        """Note that a survey has started with this annotation."""
        named = next_name(self.value.name)
        self.value = replace(self.value, name=named, notes="", position=None)
