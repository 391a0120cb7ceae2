"""Runs the live server until it is stopped."""

from __future__ import annotations

import errno
import os
import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import uvicorn

from robomore.errors import InputError
from robomore.serve.app import application
from robomore.serve.guard import LOOPBACK

_POLITE = 5
"""Added to this process's niceness, so that runs come first."""
_EVERY = {"0.0.0.0": "192.0.2.1", "::": "2001:db8::1"}
"""Hosts that mean all interfaces, and a foreign address that nobody has (RFC 5737, 3849)."""


def serve(root: Path, host: str, port: int, tell: Callable[[str], None]) -> None:
    """Show the runs below a folder until Ctrl-C.

    Args:
        root: of the runs.
        host: to listen on. Anything but this machine itself takes a token.
        port: to listen on; 0 for any that is free.
        tell: told the address.

    Raises:
        InputError: the address cannot be listened on.
    """
    token = "" if host in LOOPBACK else secrets.token_urlsafe(24)
    listening = _listening(host, port)
    taken = listening.getsockname()[1]
    names = set(LOOPBACK) | {host}
    if token:
        names |= {socket.gethostname(), socket.getfqdn()}
    with suppress(OSError, AttributeError):  # not on every system
        os.nice(_POLITE)
    shown = _own_address(host) if host in _EVERY else host
    shown = f"[{shown}]" if ":" in shown else shown
    tell(f"http://{shown}:{taken}/" + (f"?token={token}" if token else ""))
    config = uvicorn.Config(
        application(root, names, token),
        log_level="warning",
        access_log=False,
        server_header=False,
        limit_concurrency=64,
        timeout_graceful_shutdown=1,
        lifespan="off",
    )
    uvicorn.Server(config).run(sockets=[listening])


def _own_address(host: str) -> str:
    """Return the address by which others reach this machine, its name where there is none.

    Many machines of a network cannot look a bare name up.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with suppress(OSError), socket.socket(family, socket.SOCK_DGRAM) as found:
        # Of a datagram socket, this chooses the interface and sends nothing.
        found.connect((_EVERY[host], 9))
        return str(found.getsockname()[0])
    return socket.gethostname()


def _listening(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    found = socket.socket(family, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind((host, port))
    except OSError as error:
        found.close()
        remedy = "give another --port" if error.errno == errno.EADDRINUSE else "give another --host"
        raise InputError(f"cannot listen on {host}:{port} ({error.strerror}); {remedy}") from None
    found.listen(64)
    return found
