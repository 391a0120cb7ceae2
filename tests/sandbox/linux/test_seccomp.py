"""The filter as a program: what it answers to each call, worked out without a kernel."""

from __future__ import annotations

import errno

import pytest

from robomore.sandbox.linux.seccomp import Instruction, program
from robomore.sandbox.linux.syscalls import ALLOWED, CONDITIONAL

ALLOW, KILL = 0x7FFF0000, 0x80000000
REFUSE, UNKNOWN = 0x50000 | errno.EPERM, 0x50000 | errno.ENOSYS
PID = 4321
MACHINES = {"x86_64": (0, 0xC000003E), "aarch64": (1, 0xC00000B7)}


def answer(steps: list[Instruction], audit: int, number: int, *arguments: int) -> int:
    """Run the filter as the kernel does and return its answer."""
    data = {0: number, 4: audit}
    for index in range(6):
        value = (arguments[index] if index < len(arguments) else 0) % 2**64
        data[16 + 8 * index] = value % 2**32
        data[20 + 8 * index] = value >> 32
    register = position = 0
    while True:
        code, if_true, if_false, value = steps[position]
        position += 1
        match code:
            case 0x20:
                register = data[value]
            case 0x54:
                register &= value
            case 0x06:
                return value
            case 0x15:
                position += if_true if register == value else if_false
            case 0x35:
                position += if_true if register >= value else if_false
            case 0x45:
                position += if_true if register & value else if_false
            case _:
                raise AssertionError(f"unknown code {code}")


@pytest.fixture(params=MACHINES)
def machine(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def ask(machine: str, name: str, *arguments: int) -> int:
    column, audit = MACHINES[machine]
    number = (ALLOWED | CONDITIONAL)[name][column]
    if number is None:
        pytest.skip(f"{machine} has no {name}")
    return answer(program(machine, PID), audit, number, *arguments)


def test_every_listed_call_is_allowed(machine: str) -> None:
    column, audit = MACHINES[machine]
    steps = program(machine, PID)
    for name, numbers in ALLOWED.items():
        if numbers[column] is not None:
            assert answer(steps, audit, numbers[column] or 0) == ALLOW, name


def test_no_number_stands_for_two_calls(machine: str) -> None:
    column = MACHINES[machine][0]
    numbers = [it[column] for it in (ALLOWED | CONDITIONAL).values() if it[column] is not None]
    assert len(numbers) == len(set(numbers))


def test_everything_else_is_refused(machine: str) -> None:
    column, audit = MACHINES[machine]
    steps = program(machine, PID)
    listed = {numbers[column] for numbers in (ALLOWED | CONDITIONAL).values()}
    for number in set(range(600)) - listed:
        assert answer(steps, audit, number) == (UNKNOWN if number >= 403 else REFUSE), number


def test_other_conventions(machine: str) -> None:
    _, audit = MACHINES[machine]
    steps = program(machine, PID)
    assert answer(steps, 0x40000003, 0) == KILL
    assert answer(steps, audit, 0x40000000 + 41) == UNKNOWN


@pytest.mark.parametrize(
    ("name", "arguments", "expected"),
    [
        ("clone", (0x003D0F00,), ALLOW),  # what pthread_create passes
        ("clone", (17,), REFUSE),  # a process
        ("clone", (0x003D0F00 | 0x10000000,), REFUSE),  # with a namespace
        ("clone", (0x003D0B00,), REFUSE),  # a thread with open files of its own
        ("close_range", (3, 255, 4), ALLOW),
        ("close_range", (3, 255, 2), REFUSE),  # the same, later
        ("kill", (PID, 9), ALLOW),
        ("kill", (PID + 1, 0), REFUSE),
        ("kill", (0, 9), REFUSE),
        ("kill", (-1, 9), REFUSE),
        ("kill", (-PID, 9), REFUSE),
        ("tgkill", (PID, PID + 1, 6), ALLOW),
        ("tgkill", (1, 1, 9), REFUSE),
        ("prctl", (15,), ALLOW),
        ("prctl", (1, 0), REFUSE),  # to outlive its parent
        ("prctl", (4, 1), REFUSE),
        ("prlimit64", (0, 7, 0, 0x7F0012345678), ALLOW),
        ("prlimit64", (0, 7, 0x7F0012345678, 0), REFUSE),
        ("prlimit64", (0, 7, 0x7F0000000000, 0), REFUSE),
        ("prlimit64", (1, 7, 0, 0x7F0012345678), REFUSE),
        ("openat", (-100, 0x1000, 0), ALLOW),
        ("openat", (-100, 0x1000, 0o1101), ALLOW),  # write, create, truncate: for Landlock to say
        ("openat", (-100, 0x1000, 0o1000), REFUSE),  # read and truncate
        ("open", (0x1000, 0o1000), REFUSE),
        ("openat", (-100, 0x1000, 0o20200002), REFUSE),  # without a name
        ("open", (0x1000, 0o20200002), REFUSE),
        ("mmap", (0, 4096, 3, 0x22, -1, 0), ALLOW),  # private memory, which limits count
        ("mmap", (0, 4096, 3, 0x4022, -1, 0), ALLOW),
        ("mmap", (0, 4096, 3, 0x1, 5, 0), ALLOW),  # a file
        ("mmap", (0, 4096, 3, 0x20022, -1, 0), ALLOW),  # what pthread_create passes
        ("mmap", (0, 4096, 3, 0x21, -1, 0), REFUSE),
        ("mmap", (0, 4096, 3, 0x23, -1, 0), REFUSE),
        ("mmap", (0, 4096, 3, 0x122, -1, 0), REFUSE),  # a stack that grows
        ("ioctl", (3, 0x5401), ALLOW),
        ("ioctl", (3, 0x5412), REFUSE),  # to type into a terminal
        ("fcntl", (3, 3), ALLOW),
        ("fcntl", (3, 8, PID + 1), REFUSE),
        ("sched_setaffinity", (0,), ALLOW),
        ("sched_setaffinity", (PID + 1,), REFUSE),
    ],
)
def test_conditions(machine: str, name: str, arguments: tuple[int, ...], expected: int) -> None:
    assert ask(machine, name, *arguments) == expected


def test_unknown_machine() -> None:
    with pytest.raises(OSError, match="riscv64"):
        program("riscv64", PID)
