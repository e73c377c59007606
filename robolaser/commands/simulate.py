"""robolaser simulate: a data set as the real cell would give it."""

import argparse
from pathlib import Path
from typing import ClassVar, final

from robolaser.commands.argument_types import count, seed
from robolaser.commands.command import Command
from robolaser.errors import OptionsClash, OutputExists

NOISES = ("pixel_px", "target_m", "joint_rad", "point_m")
OWN = {"sensor": "stripe", "poses": 40, "points": None, "repeats": 1, "unplaced": False, **dict.fromkeys(NOISES)}
"""What the paper's experiment fixes, and what it is elsewhere unless something else is asked for."""


@final
class Simulate(Command):
    """Makes a data set."""

    name: ClassVar[str] = "simulate"
    summary: ClassVar[str] = "make a data set as a real cell would give it, with noise and effects you choose"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument("--robot", metavar="NAME_OR_URDF", required=True, help="see `robolaser list robots`")
        parser.add_argument("--flange", metavar="FRAME", help="of a URDF file: the frame that carries the sensor")
        parser.add_argument("--output", metavar="DATASET", type=Path, required=True, help="folder for the data set")
        parser.add_argument(
            "--sensor", choices=("stripe", "point", "socket"), default=OWN["sensor"], help="default: stripe"
        )
        parser.add_argument("--poses", metavar="N", type=count, default=OWN["poses"], help="default: 40")
        parser.add_argument(
            "--points", metavar="N", type=count, help="in each pose; default: 12 of a stripe, 3 reflectors, 3 sockets"
        )
        parser.add_argument(
            "--repeats", metavar="N", type=count, default=OWN["repeats"], help="shots in each pose; default: 1"
        )
        for name in NOISES:
            parser.add_argument(f"--{name.replace('_', '-')}", metavar="STD", type=float, help=f"noise, {name}")
        parser.add_argument("--unplaced", action="store_true", help="the target's place is not told")
        parser.add_argument(
            "--effect",
            metavar="NAME[:WHERE]=SIZE",
            action="append",
            default=[],
            help="an effect, SI, see `list effects`",
        )
        parser.add_argument(
            "--paper", action="store_true", help="the experiment of Lee et al. 2004: 25 points, 5 poses"
        )
        parser.add_argument("--seed", metavar="N", type=seed, default=1, help="default: 1")
        parser.add_argument("--force", action="store_true", help="overwrite a data set that is there")

    def run(self, args: argparse.Namespace) -> None:
        """Simulate, write, and say what was made."""
        from robolaser.data.dataset import Noise  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.data.writing import save  # noqa: PLC0415
        from robolaser.geometry.robots import find_robot  # noqa: PLC0415
        from robolaser.simulation import paper, simulate, sizes_of  # noqa: PLC0415

        if (args.output / "dataset.toml").exists() and not args.force:
            raise OutputExists(args.output / "dataset.toml")
        clashing = [f"--{name.replace('_', '-')}" for name, usual in OWN.items() if getattr(args, name) != usual]
        if args.paper and clashing:
            raise OptionsClash("--paper", clashing)
        robot = find_robot(args.robot, flange=args.flange)
        effects = sizes_of(args.effect)
        if args.paper:
            made = paper(robot, effects=effects, seed=args.seed)
        else:
            asked = {name: getattr(args, name) for name in NOISES if getattr(args, name) is not None}
            made = simulate(
                robot,
                kind=args.sensor,
                poses=args.poses,
                points=args.points,
                repeats=args.repeats,
                noise=Noise(**asked) if asked else None,
                placed=not args.unplaced,
                effects=effects,
                name=args.output.resolve().name,
                seed=args.seed,
            )
        save(made.dataset, args.output, overwrite=args.force)
        print(
            f"{len(made.dataset.points)} points in {len(made.dataset.poses)} poses of {robot.name}. Wrote {args.output}"
        )
