"""Joining a Ray cluster, or starting one on this machine: with a token, and without our keys.

Ray lets whoever reaches its ports run code, unless a token is asked for. Up to Ray 2.60 only
clusters that `ray.init` starts ask for one by default; from 2.61 on all do. So the token is
switched on here, and a cluster that works without one is refused.
"""

from __future__ import annotations

import importlib
import logging
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from robomore.errors import InputError
from robomore.processes import clean_environment

log = logging.getLogger(__name__)

_MODE = "RAY_AUTH_MODE"
_PATIENCE = 10.0
"""Seconds until a machine that does not answer is taken to be none of a cluster."""
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_PASSED_ON = ("RAY_", "CUDA_", "NVIDIA_")
"""Variables that a local cluster gets besides those of the allow-list."""
_PROBE = """
import sys
from ray._raylet import GcsClient
try:
    GcsClient(address=sys.argv[1]).internal_kv_keys(b"", b"", timeout=10)
except Exception as error:
    sys.exit(0 if type(error).__name__ == "AuthenticationError" else f"{error}")
sys.exit(3)
"""
"""Asks a cluster for something without a token. It ends with 0 if that is refused, and with 3 if
the cluster answers."""


def ray_module() -> Any:
    """Import Ray.

    Raises:
        InputError: it is not installed.
    """
    # What it would report to its makers is none of their business.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault(_MODE, "token")
    try:
        import ray
    except ImportError as error:
        raise InputError(
            f"--executor ray needs the package ray ({error}); pip install 'robomore[ray]'"
        ) from None
    return ray


def read_token_again() -> None:
    """Let Ray read mode and token now: it reads them once, perhaps before they were set."""
    raylet = importlib.import_module("ray._raylet")
    raylet.Config.initialize("")
    raylet.AuthenticationTokenLoader.instance().reset_cache()


def connect(address: str | None) -> None:
    """Join the cluster at `address`, or start one on this machine that ends with this process.

    Args:
        address: `auto` for the cluster that this machine belongs to, `HOST:PORT`, or `None`.

    Raises:
        InputError: there is no such cluster, or anybody may use it, or it refuses us.
    """
    if address is not None and "://" in address:
        raise InputError(
            f"--ray-address {address}: Ray's client protocol is not used; run on a machine of the "
            "cluster, and give `auto` or HOST:PORT"
        )
    if address not in (None, "auto"):
        _refuse_silent(address)
    if os.environ.get(_MODE, "token") == "disabled":
        raise InputError(
            f"{_MODE}=disabled lets anybody run programs on the cluster; unset it, and start the "
            f"cluster with {_MODE}=token"
        )
    ray = ray_module()
    if ray.is_initialized():
        raise InputError("this process uses a Ray cluster already; call ray.shutdown() first")
    read_token_again()
    options = {"log_to_driver": True, "logging_level": logging.WARNING}
    handlers = {number: signal.getsignal(number) for number in _SIGNALS}
    try:
        if address is None:
            with _without_keys():
                ray.init(
                    address="local",
                    include_dashboard=False,
                    dashboard_host="127.0.0.1",
                    **options,
                )
            _hide_token()
        else:
            ray.init(address=address, **options)
    except (ConnectionError, OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        where = f"--ray-address {address}" if address else "a Ray cluster on this machine"
        raise InputError(
            f"{where}: {_short(error)}. A cluster must be running, this machine must belong to it "
            "(ray start --address=HOST:PORT --num-cpus=0), and both need the same token "
            "(ray get-auth-token --generate)"
        ) from None
    if threading.current_thread() is threading.main_thread():
        for number, handler in handlers.items():
            # Ray's own would abort, where the command stops in good order.
            signal.signal(number, handler or signal.SIG_DFL)
    if address is None:
        return
    try:
        _refuse_open(ray.get_runtime_context().gcs_address)
    except InputError:
        ray.shutdown()
        raise


def _refuse_silent(address: str) -> None:
    """Refuse an address at which nothing listens; Ray would wait for minutes.

    Raises:
        InputError: there is nothing, or it is no address.
    """
    host, _, port = address.rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=_PATIENCE).close()
    except (OSError, ValueError, OverflowError) as error:
        reason = f"nothing answers there ({error})"
        if not isinstance(error, OSError):
            reason = "it is no HOST:PORT"
        raise InputError(
            f"--ray-address {address}: {reason}; give `auto`, or the address that `ray start "
            "--head` named (its port is 6379 unless you chose another)"
        ) from None


def _refuse_open(address: str) -> None:
    """Refuse a cluster that answers without a token.

    Raises:
        InputError: it does, or it cannot be found out.
    """
    environment = clean_environment() | {_MODE: "disabled", "HOME": os.devnull}
    probe = subprocess.run(
        [sys.executable, "-c", _PROBE, address],
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    if probe.returncode == 0:
        return
    if probe.returncode == 3:
        raise InputError(
            f"the Ray cluster at {address} asks for no token, so anybody who reaches it can run "
            f"programs on it, and here; start it with {_MODE}=token in the environment of every "
            "`ray start`"
        )
    raise InputError(
        f"it cannot be found out whether the Ray cluster at {address} asks for a token: "
        f"{_short(probe.stderr)}"
    )


def _hide_token() -> None:
    """Let nobody else on this machine read the token that Ray made."""
    with suppress(OSError):
        (Path.home() / ".ray" / "auth_token").chmod(0o600)


@contextmanager
def _without_keys() -> Iterator[None]:
    """Let the processes that Ray starts inherit an allow-list of our environment."""
    before = dict(os.environ)
    kept = {name: value for name, value in before.items() if name.startswith(_PASSED_ON)}
    wanted = clean_environment() | kept
    for name in before.keys() - wanted.keys():
        del os.environ[name]
    try:
        yield
    finally:
        os.environ.update(before)


def _short(error: object) -> str:
    return " ".join(str(error).split())[:500]
