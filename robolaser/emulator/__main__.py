"""`python -m robolaser.emulator CELL`: the emulator as a process of its own."""

import argparse
import sys
from collections.abc import Sequence

from robolaser.emulator.serving import declare, serve
from robolaser.errors import RobolaserError, SystemSaidNo, WrongUsage


def main(argv: Sequence[str] | None = None) -> int:
    """Serve.

    Returns:
        0: ended. 1: the cell cannot be emulated, see standard error. 2: wrong usage.
    """
    parser = argparse.ArgumentParser(prog="python -m robolaser.emulator", description="A cell that is not there.")
    declare(parser)
    try:
        serve(parser.parse_args(argv))
    except RobolaserError as error:
        print(f"robolaser: {error}", file=sys.stderr)
        return 2 if isinstance(error, WrongUsage) else 1
    except OSError as error:
        print(f"robolaser: {SystemSaidNo(error)}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
