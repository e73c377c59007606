"""A small emulated cell: a SCORBOT or a servo arm with the paper's scanner."""

from pathlib import Path

from robolaser.robot.by_name import find_robot

DATASET = """
format = "robolaser-dataset/1"
name = "emulated"

[robot]
urdf = "robot.urdf"
flange = "flange"
joints = ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5"]

[sensor]
kind = "stripe"
stripe_axis = "u"

[scanner]
bracket_quat = [0, 0, 0, 1]

[image]
width_px = 640
height_px = 480

[board]
columns = 9
rows = 7
square_m = 0.010

[target]
placed = false

[parameters]
f = { nominal = 8e-3, lower = 6e-3, upper = 10e-3 }
s_u = { nominal = 7.4e-6, lower = 5e-6, upper = 1e-4 }
s_v = { nominal = 7.4e-6, lower = 5e-6, upper = 1e-4 }
u_0 = { nominal = 320, lower = 290, upper = 340 }
v_0 = { nominal = 240, lower = 200, upper = 250 }
k = { nominal = 0, lower = 0, upper = 1e5 }
b = { nominal = 0.14, lower = 0.1, upper = 0.2 }
theta = { nominal = 0.43633, lower = 0, upper = 0.785398 }
w = { nominal = 0, lower = -0.0872665, upper = 0.0872665 }
phi = { nominal = 0, lower = -0.0872665, upper = 0.0872665 }
psi = { nominal = 0, lower = -0.0872665, upper = 0.0872665 }
t_x = { nominal = 0.07, lower = 0.05, upper = 0.1 }
t_y = { nominal = -0.005, lower = -0.01, upper = 0 }
t_z = { nominal = -0.065, lower = -0.1, upper = -0.05 }
"""
ARMS = {
    "acl": 'kind = "acl"\naxes = "er7"\nport = "/dev/ttyUSB0"\nbaud = 9600\n'
    "reference_rad = [0, 0, 0, -1.5707963267948966, 0]\ndirection = [1, -1, 1, 1, -1]",
    "er5plus": 'kind = "acl"\naxes = "er5plus"\nport = "/dev/ttyUSB0"\n'
    "reference_rad = [0, 0, 0, -1.5707963267948966, 0]\ndirection = [-1, 1, 1, 1, -1]",
    "dynamixel": 'kind = "dynamixel"\nport = "/dev/ttyUSB0"\nbaud = 57600\nreference_rad = [0, 0, 0.2, 0, 0]\n'
    "direction = [1, 1, -1, 1, 1]\nids = [11, 12, 13, 14, 15]",
    "feetech": 'kind = "feetech"\nport = "/dev/ttyUSB0"\nbaud = 1000000\nreference_rad = [0, 0, 0, -0.3, 0]',
    "ur": 'kind = "ur"\nport = "192.0.2.1"',
    "lss": 'kind = "lss"\nport = "/dev/ttyUSB0"\nbaud = 115200\nreference_rad = [0, 0, 0.2, 0, 0]\n'
    "direction = [1, 1, -1, 1, 1]",
}
WORLD = """
format = "robolaser-world/1"

[floor]
height_m = -0.03

[board]
origin_m = [0.54, 0.0, -0.029]

[[effect]]
name = "backlash"
where = "joint_2"
size = 0.003
"""
LASER = {"acl": "[laser]\noutput = 1\n"}


def cell_folder(tmp_path: Path, kind: str = "acl") -> Path:
    """Write a cell with one of `ARMS`; returns its folder."""
    folder = tmp_path / f"cell-{kind}"
    folder.mkdir()
    (folder / "robot.urdf").write_text(find_robot("scorbot_er7").urdf, encoding="utf-8")
    (folder / "dataset.toml").write_text(DATASET, encoding="utf-8")
    (folder / "cell.toml").write_text(
        f'format = "robolaser-cell/1"\n\n[arm]\n{ARMS[kind]}\n\n'
        '[camera]\nsource = "tcp://127.0.0.1:5001"\nsettle_s = 0.3\n\n'
        f"{LASER.get(kind, '')}[limits]\nfloor_m = 0.02\nspeed_rad_s = 0.3\n",
        encoding="utf-8",
    )
    return folder


def world_file(folder: Path) -> Path:
    """Write a world with a board on the floor; returns its file."""
    path = folder / "world.toml"
    path.write_text(WORLD, encoding="utf-8")
    return path
