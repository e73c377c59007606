"""`python -m robolaser` is `robolaser`."""

import sys

from robolaser.cli import main

sys.exit(main())
