"""What tests ask of errors: their fault, whose code stays when a sentence is reworded."""

from __future__ import annotations

import contextlib
from typing import Iterator, Tuple, Type, Union

import pytest

from gpr20_common.errors import Gpr20Error
from gpr20_common.message import Fault


@contextlib.contextmanager
def raises_fault(
    fault: Union[Fault, str, Tuple[Fault, ...]],
    *shown: object,
    error: Type[Gpr20Error] = Gpr20Error,
) -> Iterator[pytest.ExceptionInfo[Gpr20Error]]:
    """Expect an error that reports this fault.

    Args:
        fault: The fault, its code, or the faults of which it is one.
        shown: Values, such as a limit or a name, that the sentence must show.
        error: Class of the error.
    """
    faults = fault if isinstance(fault, tuple) else (fault,)
    codes = [one.code if isinstance(one, Fault) else one for one in faults]
    with pytest.raises(error) as caught:
        yield caught
    assert caught.value.message.fault_code in codes, caught.value
    for value in shown:
        assert str(value) in str(caught.value)
