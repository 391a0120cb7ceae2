"""`python -m robomore` is the command `robomore`."""

from __future__ import annotations

import sys

from robomore.cli import main

if __name__ == "__main__":
    sys.exit(main())
