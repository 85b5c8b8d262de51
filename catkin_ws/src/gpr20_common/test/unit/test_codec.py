"""Records from mappings, and back."""

import enum
import math
from dataclasses import dataclass
from typing import Optional, Tuple

from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.codec import bounded, plain, record_from


class Colour(enum.Enum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Wheel:
    radius: float = bounded(0.1, 2.0)
    spokes: int = 8


@dataclass(frozen=True)
class Cart:
    name: str
    load: Optional[float] = None
    colour: Colour = Colour.RED
    numbers: Tuple[int, ...] = ()
    spare: Wheel = Wheel(0.5, 6)
    wheels: Tuple[Wheel, ...] = ()
    open: bool = False


def test_everything_can_be_given():
    values = {
        "name": "a",
        "load": 3,
        "colour": "blue",
        "numbers": [1, 2],
        "spare": {"radius": 1},
        "wheels": [{"radius": 0.2, "spokes": 4}],
        "open": True,
    }
    cart = record_from(Cart, values, "cart")
    assert cart == Cart("a", 3.0, Colour.BLUE, (1, 2), Wheel(1.0, 8), (Wheel(0.2, 4),), True)
    assert isinstance(cart.load, float)
    assert record_from(Cart, plain(cart), "") == cart


def test_keys_of_others_can_be_left_out_and_nan_is_none():
    assert record_from(Cart, {"name": "a", "by": "b"}, "", others=True) == Cart("a")
    assert plain(Cart("a", math.nan))["load"] is None


NAMED = {"name": "a"}


@each_case(
    "values, shown",
    [
        ({}, ("cart/name",)),
        (["name"], ("cart", "['name']")),
        ({**NAMED, "nmae": "a"}, ("cart/nmae", "colour, load")),
        ({"name": "half \ud83d"}, ("cart",)),
        ({"name": 3}, ("cart/name", 3, "text")),
        ({**NAMED, "load": True}, ("cart/load", True, "number")),
        ({**NAMED, "load": "3"}, ("cart/load", "'3'")),
        ({**NAMED, "load": 10**400}, ("cart/load",)),
        ({**NAMED, "colour": "green"}, ("cart/colour", "'green'", "red, blue")),
        ({**NAMED, "numbers": 3}, ("cart/numbers", 3)),
        ({**NAMED, "numbers": [1, 2.5]}, ("cart/numbers[1]", 2.5)),
        ({**NAMED, "spare": {"radius": 3}}, ("cart/spare/radius", 3, 0.1, 2)),
        ({**NAMED, "spare": {"radius": math.nan}}, ("cart/spare/radius", "nan")),
        ({**NAMED, "wheels": [{}]}, ("cart/wheels[0]/radius",)),
        ({**NAMED, "open": 1}, ("cart/open", 1, "true or false")),
    ],
)
def test_what_does_not_fit_is_named(values, shown):
    with raises_fault((faults.NOT_ALLOWED, faults.CONFIGURATION), *shown, error=InvalidValueError):
        record_from(Cart, values, "cart")
