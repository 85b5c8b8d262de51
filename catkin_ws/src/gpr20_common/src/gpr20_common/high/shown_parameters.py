"""The parameters that a node has, under its own name: `rosparam get /x_axis/axis_driver/max_step`.

They are shown, not read: changing them changes nothing (module `parameters`).
"""

from __future__ import annotations

import enum
import json
from typing import Any, Mapping

import rosgraph
import rospy

from gpr20_common.high.parameters import configuration_name
from gpr20_common.low.limited_rpc import NO_ANSWER, limited_server, value_of

# The master answers within this time, or is gone [s].
ANSWER_LIMIT_S = 1.0
LARGEST_INT = 2**31 - 1
"""XML-RPC has no larger ones."""


def show_parameters(values: Mapping[str, Any]) -> None:
    """Show the parameters of this node, with their defaults, until it ends.

    A node that was started alone shows none: it refuses private parameters, and could not
    distinguish what a killed one has left behind.

    Args:
        values: The parameters by their names.
    """
    if not configuration_name():
        return
    master = limited_server(rosgraph.get_master_uri(), ANSWER_LIMIT_S)
    name = rospy.get_name()

    def remove() -> None:
        try:
            value_of(master.deleteParam(name, name))
        except NO_ANSWER as error:
            rospy.logdebug("the shown parameters were not removed: %s", error)

    try:
        value_of(master.setParam(name, name, shown(values)))
    except NO_ANSWER as error:
        rospy.logwarn("the parameters cannot be shown: %s", error)
        return
    rospy.on_shutdown(remove)


def shown(value: Any) -> Any:
    """Return a value as the parameter server can hold it; None is an empty text."""
    if value is None:
        return ""
    if isinstance(value, enum.Enum):
        return shown(value.value)
    if isinstance(value, Mapping):
        return {str(key): shown(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [shown(one) for one in value]
    if isinstance(value, int) and abs(value) > LARGEST_INT:
        return float(value)
    if isinstance(value, str) and not value.isprintable():
        return json.dumps(value)
    return value
