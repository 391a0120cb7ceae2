"""The hostile programs in `rewards/`. The first lines of each say what is to come of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent / "rewards"

MECHANISMS = {
    "files by name": ("read/open", "read/symbolic_link", "read/openat2", "write/outside"),
    "files through the C library": ("read/ctypes_through_numpy",),
    "files through NumPy": ("read/load_pickle", "read/fromfile"),
    "files through /proc": ("read/proc_root", "read/environment_of_parent"),
    "memory of other processes": ("read/parent_memory", "process/write_parent_memory"),
    "open files of other processes": ("read/inherited_descriptors", "read/pidfd_getfd"),
    "objects of the interpreter": ("read/search_memory", "escape/generator_frame"),
    "neighbours": ("read/neighbour_checkpoint", "write/neighbour_checkpoint"),
    "the ledger": ("write/ledger_by_sqlite", "write/truncate_readable"),
    "files that mislead a reader": ("write/link_left_for_reader", "write/pipe_left_for_reader"),
    "owners, modes and times": ("write/lock_out", "write/chown", "write/times"),
    "shared memory": ("write/shared_memory_object", "availability/shared_map"),
    "sockets": ("network/tcp", "network/udp", "network/unix_abstract", "network/inherited_socket"),
    "unusual system calls": ("network/io_uring", "network/machine_code_32_bit"),
    "new processes": ("process/fork", "process/clone_three", "process/exec_from_memory"),
    "signals": ("process/kill_parent", "process/signal_by_descriptor"),
    "limits and privileges": ("process/raise_own_limits", "process/namespaces"),
    "threads": ("process/threads", "process/thread_left"),
    "outliving the parent": ("process/outlive_parent", "process/exit_hook"),
    "deafness to signals": ("process/deaf_to_signals",),
    "sudden death": ("process/segmentation_fault", "process/exit"),
    "forged replies": ("cheat/forged_reply", "cheat/forged_verdict_ok", "cheat/endless_reply"),
    "malformed replies": ("cheat/forged_verdict_deep", "cheat/lock_again"),
    "forged policies": ("cheat/own_policy_and_reply", "cheat/huge_policy"),
    "the physics": ("cheat/write_positions", "cheat/change_gravity"),
    "libraries": ("cheat/patch_numpy", "cheat/patch_robomore", "escape/import_hook"),
    "the watchdog": ("cheat/stop_the_heartbeat", "availability/between_calls"),
    "format strings": ("escape/format_string",),
    "types and descriptors": ("escape/subclasses", "escape/metaclass", "escape/descriptor"),
    "pickle": ("escape/reduce_left_behind",),
    "hooks of the interpreter": ("escape/exception_hook", "escape/codec_hook"),
    "values that run code": ("escape/hostile_float", "escape/hostile_message"),
    "machine code": ("escape/native_code", "escape/small_integers"),
    "text for a terminal": ("escape/terminal_codes",),
    "endless work": ("availability/endless_loop", "availability/regular_expression"),
    "endless work while loading": ("availability/endless_loop_at_import",),
    "idleness": ("availability/sleep",),
    "memory": ("availability/huge_array", "availability/leak"),
    "memory that is not watched": (
        *("availability/main_thread_ends", "availability/growing_stack"),
    ),
    "memory in the kernel": (
        *("availability/pages_in_pipes", "availability/descriptors_of_a_thread"),
    ),
    "disk": ("availability/big_file", "availability/removed_while_open"),
    "disk without names": ("availability/nameless_file", "availability/move_while_counted"),
    "output": ("availability/print_gigabyte",),
    "programs that do not load": ("broken/syntax", "broken/no_function", "broken/raises_at_import"),
    "programs that raise": ("broken/exit", "broken/memory_error", "broken/unknown_name"),
    "programs that return nonsense": ("broken/returns_nan", "broken/terms_none"),
}
"""Ways to do harm, and the most telling programs of each. These run by default."""


@dataclass(frozen=True)
class Attempt:
    """One program.

    Attributes:
        name: folder and file.
        words: what it tries.
        source: its text, with placeholders such as `@SECRET@` to be filled in.
        expected: the statuses with which its evaluation may end.
        check: what the static check may find at worst: `error`, `warning` or `clean`.
    """

    name: str
    words: str
    source: str
    expected: tuple[str, ...]
    check: tuple[str, ...]


@cache
def attempts() -> dict[str, Attempt]:
    """Return all of them by name."""
    return {it.name: it for it in map(_read, sorted(FOLDER.glob("*/*.py")))}


def parameters() -> list[object]:
    """Return all of them as parameters of a test; the less telling ones are `exhaustive`."""
    telling = {name for names in MECHANISMS.values() for name in names}
    found = attempts()
    assert telling <= found.keys(), telling - found.keys()
    return [
        pytest.param(it, id=name, marks=() if name in telling else pytest.mark.exhaustive)
        for name, it in found.items()
    ]


def _read(path: Path) -> Attempt:
    source = path.read_text()
    header = dict(line[2:].split(": ", 1) for line in source.splitlines()[:3])
    return Attempt(
        name=f"{path.parent.name}/{path.stem}",
        words=header["attempt"],
        source=source,
        expected=tuple(header["expect"].split(" or ")),
        check=tuple(header["check"].split(" or ")),
    )
