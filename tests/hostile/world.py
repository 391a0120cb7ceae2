"""A world worth breaking into: secrets, listeners, a ledger, a neighbour; and the damage done."""

from __future__ import annotations

import contextlib
import json
import os
import pickle
import secrets
import shutil
import socket
import sqlite3
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from robomore.sandbox.call import SandboxResult
from robomore.training.checkpoint import Checkpoint, save_checkpoint

TEMPORARY = (Path("/tmp"), Path("/var/tmp"), Path("/dev/shm"))


@dataclass
class World:
    """Planted secrets and other targets, and their state before.

    Attributes:
        root: folder that holds all of it.
        token: the secret: in a file, a module, a database and an environment variable.
        mark: name that attempts give to what they leave behind.
        variable: name of the environment variable.
        tcp, udp, unix, abstract: sockets that nobody should reach.
    """

    root: Path
    token: str = field(default_factory=lambda: f"token{secrets.token_hex(12)}")
    mark: str = field(default_factory=lambda: f"mark{secrets.token_hex(6)}")
    variable: str = "ROBOMORE_TEST_API_KEY"

    def __post_init__(self) -> None:
        for folder in ("outside", "neighbour", "readable"):
            (self.root / folder).mkdir()
        (self.outside / "secret.txt").write_text(self.token)
        (self.outside / "planted_module.py").write_text(f"SECRET = {self.token!r}\n")
        (self.outside / "secret.pkl").write_bytes(pickle.dumps(self.token))
        np.save(self.outside / "secret.npy", np.array(self.token.encode()))
        (self.root / "neighbour/policy.json").write_text(f'{{"force": 0.5, "x": "{self.token}"}}')
        checkpoint = Checkpoint({"seed": 1}, {"weight": np.ones(3)}, {"qpos": np.zeros(3)})
        save_checkpoint(self.root / "neighbour", checkpoint)
        (self.root / "readable/readable.txt").write_text("may be read")
        with contextlib.closing(sqlite3.connect(self.ledger)) as ledger, ledger:
            ledger.execute("create table evaluations (fitness real, note text)")
            ledger.execute("insert into evaluations values (1.0, ?)", [self.token])
        os.environ[self.variable] = self.token
        self.tcp = socket.create_server(("127.0.0.1", 0))
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(self.tcp.getsockname())
        self.unix = socket.socket(socket.AF_UNIX)
        self.unix.bind(str(self.root / "s"))
        self.abstract = socket.socket(socket.AF_UNIX)
        self.abstract.bind(f"\0{self.mark}")
        for listener in (self.tcp, self.unix, self.abstract):
            listener.listen()
        for endpoint in (self.tcp, self.udp, self.unix, self.abstract):
            endpoint.setblocking(False)
        self._before = self._state()

    @property
    def outside(self) -> Path:
        return self.root / "outside"

    @property
    def ledger(self) -> Path:
        return self.outside / "ledger.sqlite"

    def scratch(self, name: str) -> Path:
        folder = self.root / "scratch" / name.replace("/", "-")
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def address(self, text: str) -> str:
        """Return the text of an attempt with its aims filled in."""
        aims = {
            "SECRET": self.outside / "secret.txt",
            "OUTSIDE": self.outside,
            "LEDGER": self.ledger,
            "NEIGHBOUR": self.root / "neighbour",
            "READABLE": self.root / "readable",
            "HOME": Path.home(),
            "SOCKET": self.root / "s",
            "PORT": self.tcp.getsockname()[1],
            "PARENT": os.getpid(),
            "VARIABLE": self.variable,
            "MARK": self.mark,
        }
        for name, aim in aims.items():
            text = text.replace(f"@{name}@", str(aim))
        return text

    def breaches(self, result: SandboxResult, scratch: Path) -> list[str]:
        """Return what got across the boundary, in words; empty if nothing did."""
        found = [f"{name} was reached" for name in self._reached()]
        said = result.diagnosis + result.log + result.reply.decode(errors="replace")
        if self.token in said:
            found.append("the secret was carried out in words")
        if "loot:" in result.diagnosis:
            found.append("something was carried out in words")
        for path in scratch.rglob("*"):
            if path.is_symlink() or not (path.is_file() or path.is_dir()):
                found.append(f"{path.name} is no plain file")
            elif path.is_file() and self.token in path.read_bytes()[:10_000].decode(
                errors="replace"
            ):
                found.append(f"the secret was carried out in {path.name}")
        if "\x1b" in said or "\u202e" in said:
            found.append("words that steer a terminal")
        if (state := self._state()) != self._before:
            changed = {
                k for k in state.keys() | self._before.keys() if state.get(k) != self._before.get(k)
            }
            found.append(f"changed: {', '.join(sorted(changed))}")
            self._before = state
        found += [f"process {pid} was left behind" for pid in self._left_running()]
        return found

    def close(self) -> None:
        os.environ.pop(self.variable, None)
        for endpoint in (self.tcp, self.udp, self.unix, self.abstract):
            endpoint.close()

    def _reached(self) -> Iterator[str]:
        for name, listener in (("TCP", self.tcp), ("Unix", self.unix), ("abstract", self.abstract)):
            with contextlib.suppress(BlockingIOError):
                listener.accept()[0].close()
                yield name
        with contextlib.suppress(BlockingIOError):
            self.udp.recv(1)
            yield "UDP"

    def _state(self) -> dict[str, object]:
        """Return all that an escape might have changed: files, modes, times, and ourselves."""
        state: dict[str, object] = {}
        for folder in (self.outside, self.root / "neighbour", self.root / "readable"):
            for path in (folder, *folder.rglob("*")) if folder.exists() else ():
                facts = path.lstat()
                content = path.read_bytes() if path.is_file() else b""
                attributes = os.listxattr(path, follow_symlinks=False)
                owner = (facts.st_mode, facts.st_uid, facts.st_nlink, facts.st_mtime_ns)
                state[str(path)] = (content, owner, tuple(attributes))
        packages = Path(np.__file__).parent
        places = (*TEMPORARY, Path.home(), Path.cwd(), packages, packages / "__pycache__")
        for place in places:
            marked = place.glob(f"*{self.mark}*") if place.is_dir() else ()
            state[f"marks in {place}"] = tuple(sorted(path.name for path in marked))
        state["affinity"] = tuple(sorted(os.sched_getaffinity(0)))
        state["priority"] = os.getpriority(os.PRIO_PROCESS, 0)
        state["host name"] = socket.gethostname()
        return state

    def _left_running(self) -> list[int]:
        """Return processes that run in a scratch folder of ours."""
        found = []
        for entry in Path("/proc").iterdir():
            if entry.name.isdigit():
                with contextlib.suppress(OSError):
                    if (entry / "cwd").readlink().is_relative_to(self.root / "scratch"):
                        found.append(int(entry.name))
        return found


@contextlib.contextmanager
def world() -> Iterator[World]:
    """A world for as long as it takes. Its folder is short, for a Unix socket's name must be."""
    with tempfile.TemporaryDirectory(prefix="rw") as folder:
        made = World(Path(folder).resolve())
        try:
            yield made
        finally:
            made.close()


def encode(source: str) -> bytes:
    """Return what `miniature.train` takes."""
    return json.dumps({"source": source}).encode()
