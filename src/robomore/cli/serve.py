"""`robomore serve`: all runs of a folder in a browser, while they go on."""

from __future__ import annotations

from pathlib import Path

from robomore.cli.output import write
from robomore.errors import InputError


def serve(folder: Path = Path("runs"), /, *, host: str = "127.0.0.1", port: int = 8765) -> None:
    """Show the runs of a folder in a browser, up to date while they go on. Ctrl-C ends it.

    It only reads, and only answers this machine. With `--host` it answers others too, who then need
    the token in the address that is printed.

    Parameters
    ----------
    folder
        A folder with runs in it, a study, or one run.
    host
        Address to listen on. Anything but 127.0.0.1 and localhost takes a token.
    port
        Port to listen on; 0 for any that is free.
    """
    from robomore.store import refuse_no_folder

    refuse_no_folder(folder, "one that `robomore run` wrote runs into")
    if not 0 <= port <= 65535:
        raise InputError(f"--port is {port}; give a number from 0 to 65535")
    try:
        from robomore.serve import serve as start
    except ImportError as error:
        raise InputError(
            f"the live page needs {error.name}, which is not installed: "
            "pip install 'robomore[serve]'"
        ) from None
    start(folder.resolve(), host, port, lambda address: write(f"{address}\n"))
