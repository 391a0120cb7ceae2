"""A sandboxed call returns its reply, or says why there is none, and leaves nothing behind."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from robomore.sandbox.call import Containment, SandboxResult, run_sandboxed
from robomore.sandbox.layers import ensure, layers
from robomore.types import Limits, Status
from strict import STRICT, strictly

LIMITS = Limits(wall_seconds=20.0, stall_seconds=10.0)


def call(
    job: str, payload: bytes, scratch: Path, limits: Limits = LIMITS, **options: object
) -> SandboxResult:
    mode = Containment.STRICT if STRICT else Containment.RELAXED
    return run_sandboxed(
        f"sandboxed_jobs:{job}",
        payload,
        scratch,
        limits,
        **{"mode": mode, "readable": [Path(__file__).parent], **options},  # type: ignore[arg-type]
    )


@pytest.fixture(autouse=True)
def no_process_left() -> Iterator[None]:
    before = _children()
    yield
    assert _children() <= before


def test_the_reply_is_returned(tmp_path: Path) -> None:
    reported: list[int] = []
    payload = os.urandom(3_000_000)
    result = call("echo", payload, tmp_path, on_progress=reported.append)
    assert result.status is Status.OK and result.diagnosis == ""
    assert result.reply == payload
    assert reported[-1] == 2
    assert 0.0 < result.seconds < 10.0


@pytest.mark.parametrize(
    "status",
    [
        *("invalid-morphology", "invalid-reward", "reward-failed", "unstable"),
        *("training-diverged", "out-of-memory", "failed"),
    ],
)
def test_errors_become_statuses(status: str, tmp_path: Path) -> None:
    result = call("fail", status.encode(), tmp_path)
    assert result.status == status
    assert result.diagnosis and result.reply == b""
    assert ("Traceback" in result.diagnosis) == (status == "failed")


def test_a_reward_that_ran_out_of_memory_is_told_from_one_that_is_wrong(tmp_path: Path) -> None:
    result = call("fail_for_memory", b"", tmp_path)
    assert result.status is Status.OUT_OF_MEMORY


def test_a_function_without_a_proper_reply(tmp_path: Path) -> None:
    assert call("no_bytes", b"", tmp_path).status is Status.FAILED
    assert call("missing", b"", tmp_path).status is Status.FAILED


def test_surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", "secret")
    monkeypatch.setenv("PYTHONPATH", "/somewhere")
    one = call("surroundings", b"", tmp_path / "a", environment={"EXTRA": "1"})
    found = json.loads(one.reply)
    assert set(found["environment"]) == {
        *("PATH", "HOME", "TMPDIR", "LANG", "TZ", "EXTRA", "MUJOCO_GL"),
        *("PYTHONHASHSEED", "PYTHONDONTWRITEBYTECODE", "PYTHONUTF8"),
        *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"),
        *("NUMEXPR_NUM_THREADS", "VECLIB_MAXIMUM_THREADS", "NPROC"),
        *(name for name in ("LD_LIBRARY_PATH", "LC_CTYPE") if name in found["environment"]),
    }
    assert "secret" not in one.reply.decode()
    assert found["folder"] == found["environment"]["HOME"] == str(tmp_path / "a")
    assert found["stdin"] == ""
    assert found["descriptors"] == 2  # the pipe of replies and the page of heartbeats
    two = json.loads(call("surroundings", b"", tmp_path / "b").reply)
    assert two["order"] == found["order"]


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ("exit", "exit status 3"),
        ("SIGSEGV", "SIGSEGV"),
        ("SIGKILL", "SIGKILL"),
        ("40", "signal 40"),
    ],
)
def test_death(how: str, words: str, tmp_path: Path) -> None:
    result = call("end", how.encode(), tmp_path)
    assert result.status is Status.CRASHED
    assert words in result.diagnosis
    assert ("last output" in result.diagnosis) == (how != "exit")


def test_long_output_is_read_and_cut(tmp_path: Path) -> None:
    result = call("talk", b"30", tmp_path)
    assert result.status is Status.OK
    assert len(result.log) <= 64 * 2**10
    assert result.log.endswith("the end\N{REPLACEMENT CHARACTER}[2J")


def test_too_much_output_ends_the_process(tmp_path: Path) -> None:
    result = call("talk", b"5000", tmp_path)
    assert result.status is Status.REWARD_FAILED
    assert "must not print" in result.diagnosis


def test_memory(tmp_path: Path) -> None:
    result = call("hoard", b"", tmp_path, replace(LIMITS, memory_bytes=300 * 2**20))
    assert result.status is Status.OUT_OF_MEMORY
    assert result.peak_memory < 500 * 2**20


@pytest.mark.parametrize(
    ("payload", "limits", "words"),
    [
        (b"report", Limits(wall_seconds=0.8), "0.8 s of wall-clock"),
        (b"", Limits(stall_seconds=0.8), "no progress for 0.8 s"),
    ],
)
def test_time(payload: bytes, limits: Limits, words: str, tmp_path: Path) -> None:
    began = time.monotonic()
    result = call("sleep", payload, tmp_path, limits)
    assert result.status is Status.TIMED_OUT
    assert words in result.diagnosis
    assert time.monotonic() - began < 8.0


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_an_error_in_the_parent_ends_the_process(
    error: type[BaseException], tmp_path: Path
) -> None:
    def stop(progress: int) -> None:
        raise error

    with pytest.raises(error):
        call("sleep", b"report", tmp_path, on_progress=stop)
    pid = int((tmp_path / "pid").read_text())
    assert not Path(f"/proc/{pid}").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="Linux ends children with their parents")
def test_the_process_ends_with_its_parent(tmp_path: Path) -> None:
    script = (
        "import sys; from pathlib import Path; sys.path.insert(0, sys.argv[1])\n"
        "from robomore.sandbox.call import *; from robomore.types import Limits\n"
        "run_sandboxed('sandboxed_jobs:sleep', b'', Path(sys.argv[2]), Limits(),"
        "readable=[Path(sys.argv[1])], mode=Containment.RELAXED)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script, Path(__file__).parent, tmp_path])
    try:
        _until(lambda: (tmp_path / "pid").exists() and (tmp_path / "pid").read_text() != "")
    finally:
        parent.send_signal(signal.SIGKILL)
        parent.wait()
    pid = int((tmp_path / "pid").read_text())
    _until(lambda: not _running(pid))


@strictly
def test_folders(tmp_path: Path) -> None:
    names = ("scratch", "readable", "writable", "other")
    for name in names:
        (tmp_path / name).mkdir()
        (tmp_path / name / "old").write_text("x")
    result = call(
        "touch",
        json.dumps([str(tmp_path / name) for name in names]).encode(),
        tmp_path / "scratch",
        readable=[Path(__file__).parent, tmp_path / "readable"],
        writable=[tmp_path / "writable", tmp_path / "made"],
    )
    worked = json.loads(result.reply)
    assert [worked[str(tmp_path / name)] for name in names] == [
        [True, True],
        [True, False],
        [True, True],
        [False, False],
    ]
    assert (tmp_path / "made").is_dir()


def test_all_folders_count_against_the_disk_limit(tmp_path: Path) -> None:
    limits = replace(LIMITS, file_bytes=2**20)
    aims = json.dumps([str(tmp_path / "scratch"), str(tmp_path / "checkpoint")]).encode()
    result = call("fill", aims, tmp_path / "scratch", limits, writable=[tmp_path / "checkpoint"])
    assert result.status is Status.REWARD_FAILED, result.diagnosis
    assert "more than 3 MiB" in result.diagnosis


@strictly
def test_no_disk_space_is_reserved(tmp_path: Path) -> None:
    result = call("reserve", b"", tmp_path, replace(LIMITS, file_bytes=2**20))
    assert json.loads(result.reply) == [-1, errno.EPERM, 0]


def test_threads_are_allowed(tmp_path: Path) -> None:
    assert json.loads(call("many_threads", b"", tmp_path).reply) == list(range(8))


def test_the_libraries_of_training_work_inside(tmp_path: Path) -> None:
    result = call("heavy", b"", tmp_path, Limits(wall_seconds=60.0, stall_seconds=60.0))
    assert result.status is Status.OK, result.diagnosis
    assert json.loads(result.reply) == [64.0**3, True]


@strictly
def test_all_layers_hold() -> None:
    assert all(layer.active for layer in layers()), layers()
    assert ensure(Containment.STRICT) == layers()


_CRIPPLED = """
import ctypes, errno, platform, sys
from pathlib import Path
from robomore.errors import InputError
from robomore.sandbox.linux import seccomp
from robomore.sandbox.call import Containment, run_sandboxed
from robomore.sandbox.layers import ensure, layers
from robomore.sandbox.linux.seccomp import Instruction
from robomore.types import Limits, Status

refused = {refused}
steps = [Instruction(0x20, 0, 0, 0)]
for number in refused:
    steps += [Instruction(0x15, 0, 1, number), Instruction(0x06, 0, 0, 0x50000 | errno.ENOSYS)]
steps.append(Instruction(0x06, 0, 0, 0x7FFF0000))
ctypes.CDLL(None).prctl(38, 1, 0, 0, 0)
seccomp.install(steps, platform.machine())

scratch = Path(sys.argv[1])
relaxed = run_sandboxed(
    "sandboxed_jobs:echo", b"x", scratch, Limits(), mode=Containment.RELAXED,
    readable=[Path(sys.argv[2])],
)
assert relaxed.status is Status.OK, relaxed
print(sorted(layer.name for layer in relaxed.layers if not layer.active))
print(sorted(layer.name for layer in layers() if not layer.active))
for refuse in (
    lambda: ensure(Containment.STRICT),
    lambda: run_sandboxed("sandboxed_jobs:echo", b"", scratch, Limits()),
):
    try:
        refuse()
    except InputError as error:
        print(error)
"""


@strictly
@pytest.mark.parametrize(
    ("numbers", "layer"),
    [
        ((444, 445, 446), "files"),
        ((317 if os.uname().machine == "x86_64" else 277,), "system calls"),
    ],
)
def test_a_machine_without_a_layer(numbers: tuple[int, ...], layer: str, tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent)}
    done = subprocess.run(
        [sys.executable, "-c", _CRIPPLED.format(refused=numbers), tmp_path, Path(__file__).parent],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    lines = done.stdout.splitlines()
    assert lines[:2] == [f"['{layer}']"] * 2, done.stdout + done.stderr
    assert len(lines) == 4
    for line in lines[2:]:
        assert layer in line and "--containment relaxed" in line


def _children() -> set[str]:
    """Return the child processes of this process, also those that have ended and wait."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if fields[1] == str(os.getpid()):
            found.add(stat.parent.name)
    return found


def _until(condition: Callable[[], bool], seconds: float = 10.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def _running(pid: int) -> bool:
    try:
        return ") Z " not in Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
