"""The root of every error that GPR-20 raises on purpose."""


class Gpr20Error(Exception):
    """Something was refused or failed; the message says what, why and what to do.

    Each package derives one error of its own from this one. The high levels catch
    this class in one place and hand its text to the operator.
    """

    @property
    def message(self) -> str:
        """What was refused or failed, why, and what to do."""
        return str(self)


class InvalidValueError(Gpr20Error, ValueError):
    """A value that came from outside is not allowed."""


class NodeSilentError(Gpr20Error, OSError):
    """A node does not answer."""
