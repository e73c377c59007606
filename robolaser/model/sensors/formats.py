"""How data sets of robolaser's own sensors look on disk."""

from robolaser.data.sensor_format import PIXEL, XYZ, SensorFormat, register_format

STRIPE = SensorFormat(
    kind="stripe",
    title="laser stripe scanner",
    columns={"pixel": PIXEL, "xyz": XYZ},
    tables=("scanner", "image", "board"),
    required=("image",),
    units={
        "f": "m", "s_u": "m/px", "s_v": "m/px", "u_0": "px", "v_0": "px", "k": "1/m²", "b": "m", "theta": "rad",
        "t_x": "m", "t_y": "m", "t_z": "m",
    },
    positive=("f", "s_u", "s_v"),
)  # fmt: skip
POINT = SensorFormat(kind="point", title="laser tracker", columns={"xyz": XYZ}, named_points=True)
SOCKET = SensorFormat(
    kind="socket",
    title="ball in fixed sockets",
    columns={},
    absent={"x_m": 'a socket\'s place is not measured (kind "point" is)'},
    named_points=True,
)

for declared in (STRIPE, POINT, SOCKET):
    register_format(declared)
