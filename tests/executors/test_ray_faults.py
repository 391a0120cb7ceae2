"""The process that directs a run is killed, and the network goes away: nothing counts twice."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest
from drive import SETTINGS
from ray_cluster import ray_cluster, until_none_is_left

from robomore.experiment import run
from tiny import numbers

HERE = Path(__file__).parent
PLACES = f"{HERE}:{HERE.parent}"

pytestmark = [
    pytest.mark.skipif(find_spec("ray") is None, reason="needs the extra ray"),
    pytest.mark.exhaustive,
]


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> object:
    """The numbers of the same run in one process."""
    import untrained

    out = tmp_path_factory.mktemp("inline") / "run"
    run("swimmer", SETTINGS, executor=untrained.Untrained(1), out=out)
    return numbers(out)


@contextmanager
def driven(address: str, folder: Path) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, str(HERE / "drive.py"), address, str(folder)],
        env=os.environ | {"PYTHONPATH": PLACES},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def until_new(process: subprocess.Popen[str], count: int) -> None:
    """Wait until so many new results have been told."""
    assert process.stdout is not None
    for line in process.stdout:
        count -= line.endswith("new\n")
        if not count:
            return
    raise AssertionError(f"it ended with status {process.wait()}")


def test_a_killed_driver_goes_on_with_the_same_cluster(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, expected: object
) -> None:
    monkeypatch.setenv("PYTHONPATH", PLACES)
    with ray_cluster(2) as cluster:
        with driven(cluster.address, tmp_path / "run") as first:
            until_new(first, 6)
        with driven(cluster.address, tmp_path / "run") as second:
            said, _ = second.communicate(timeout=600)
            assert second.returncode == 0
    assert said.count("known") >= 6
    assert numbers(tmp_path / "run") == expected
    assert not until_none_is_left()


@pytest.mark.skipif(os.getuid() != 0 or shutil.which("ip") is None, reason="needs root and ip")
def test_a_network_that_is_away_for_half_a_minute(tmp_path: Path, expected: object) -> None:
    ray = [sys.executable, "-m", "ray.scripts.scripts"]
    environment = os.environ | {
        "RAY_AUTH_MODE": "token",
        "RAY_AUTH_TOKEN": "network-" * 5,
        "RAY_worker_niceness": "0",
        "PYTHONPATH": PLACES,
    }

    def ip(words: str) -> None:
        subprocess.run(["ip", *words.split()], check=True)

    ip("netns add robomore-far")
    started: list[subprocess.Popen[bytes]] = []
    try:
        ip("link add robomore0 type veth peer name robomore1")
        ip("link set robomore1 netns robomore-far")
        ip("addr add 10.77.0.1/24 dev robomore0")
        ip("link set robomore0 up")
        for words in ("addr add 10.77.0.2/24 dev robomore1", "link set robomore1 up"):
            ip(f"-n robomore-far {words}")
        ip("-n robomore-far link set lo up")
        head = ["--head", "--node-ip-address=10.77.0.1", "--port=26379", "--num-cpus=1"]
        far = ["--address=10.77.0.1:26379", "--node-ip-address=10.77.0.2", "--num-cpus=1"]
        for prefix, words in (([], head), (["ip", "netns", "exec", "robomore-far"], far)):
            options = ["start", "--block", "--include-dashboard=false", *words]
            if words is far:
                options.remove("--include-dashboard=false")
            started.append(subprocess.Popen([*prefix, *ray, *options], env=environment))
            time.sleep(15)
        with pytest.MonkeyPatch.context() as patch:
            for name, value in environment.items():
                patch.setenv(name, value)
            with driven("10.77.0.1:26379", tmp_path / "run") as driver:
                until_new(driver, 4)
                ip("link set robomore0 down")
                time.sleep(30)
                ip("link set robomore0 up")
                driver.communicate(timeout=900)
                assert driver.returncode == 0
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            process.wait(timeout=60)
        subprocess.run(["ip", "link", "del", "robomore0"], stderr=subprocess.DEVNULL)
        ip("netns del robomore-far")
    assert numbers(tmp_path / "run") == expected
