"""The command line: one module for each group of commands, loaded when its command is used.

`app` holds the list of commands and turns every error into one line and an exit status. A command
is a function whose signature is its usage; a new one needs an entry in `app.COMMANDS` and no more.
"""

from __future__ import annotations

from robomore.cli.app import main

__all__ = ["main"]
