"""Names of the coordinate frames of the robot.

`map` -> `base_link` (the origin of the axes on the ground; x along X, y along Y, z up; metres) ->
`y_carriage_link` -> `x_carriage_link` -> `antenna_link`, which turns about z, and
`height_sensor_link`. A robot in a namespace has the same names on its own `tf`.
"""

MAP = "map"
BASE_LINK = "base_link"
Y_CARRIAGE_LINK = "y_carriage_link"
X_CARRIAGE_LINK = "x_carriage_link"
ANTENNA_LINK = "antenna_link"
HEIGHT_SENSOR_LINK = "height_sensor_link"
