"""Records from mappings."""

import enum
import math
from dataclasses import dataclass, field
from typing import Optional, Tuple

from case_kit import each_case
from fault_kit import raises_fault

from gpr20_common import faults
from gpr20_common.errors import InvalidValueError
from gpr20_common.mid.records import bounded, record_from


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
    spare: Wheel = field(default_factory=lambda: Wheel(0.5, 6))
    wheels: Tuple[Wheel, ...] = ()
    open: bool = False


def test_what_is_left_out_has_its_default():
    assert record_from(Cart, {"name": "a"}, "cart") == Cart("a")


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
    assert cart == Cart("a", 3.0, Colour.BLUE, (1, 2), Wheel(1.0, 6), (Wheel(0.2, 4),), True)
    assert isinstance(cart.load, float)


@each_case(
    "change, shown",
    [
        ({"nmae": "a"}, ("cart/nmae", "colour, load")),
        ({"name": 3}, ("cart/name", 3, "str")),
        ({"load": True}, ("cart/load", True, "float")),
        ({"load": "3"}, ("cart/load", "'3'")),
        ({"load": 10**400}, ("cart/load",)),
        ({"spare": {"radius": 10**400}}, ("cart/spare/radius",)),
        ({"colour": "green"}, ("cart/colour", "'green'", "red, blue")),
        ({"numbers": 3}, ("cart/numbers", 3)),
        ({"numbers": [1, 2.5]}, ("cart/numbers[1]", 2.5)),
        ({"spare": {"radius": 3}}, ("cart/spare/radius", 3, 0.1, 2)),
        ({"spare": {"radius": math.nan}}, ("cart/spare/radius", "nan")),
        ({"spare": 4}, ("cart/spare", 4)),
        ({"wheels": [{}]}, ("cart/wheels[0]/radius",)),
        ({"open": 1}, ("cart/open", 1, "bool")),
    ],
)
def test_what_does_not_fit_is_named(change, shown):
    with raises_fault((faults.NOT_ALLOWED, faults.CONFIGURATION), *shown, error=InvalidValueError):
        record_from(Cart, {"name": "a", **change}, "cart")


def test_a_value_that_must_be_there_is_named():
    with raises_fault(faults.CONFIGURATION, "cart/name"):
        record_from(Cart, {}, "cart")


def test_what_is_not_a_mapping_is_refused():
    with raises_fault(faults.CONFIGURATION, "cart", "['name']"):
        record_from(Cart, ["name"], "cart")
