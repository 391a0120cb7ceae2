"""The batch script: what it asks for, what it keeps to itself, and that it runs."""

from __future__ import annotations

import re
import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest
from slurm_machine import lacking, slurm

from robomore import load_run
from robomore.cli.app import main
from robomore.errors import InputError
from robomore.executors.slurm import Allocation, sbatch_script

TINY = (
    *("run", "swimmer", "--preset", "smoke", "--method", "reference", "--quiet"),
    *("--steps", "512", "--final-seeds", "1", "--final-steps", "512"),
    *("--trainer-option", "net_arch=[16]", "--trainer-option", "learning_starts=256"),
)


def test_it_asks_for_what_was_said() -> None:
    allocation = Allocation(
        nodes=4,
        seconds=26 * 3600 + 90,
        cores_per_node=16,
        memory_per_node=64 * 2**30,
        partition="long",
        account="group-7",
    )
    script = sbatch_script(allocation, ("run", "ant", "--out", "my runs/one"), Path("/k e/y.env"))
    found = re.findall(r"^#SBATCH (--\S+)$", script, re.MULTILINE)
    assert {
        *("--nodes=4", "--time=1-02:02:00", "--cpus-per-task=16", "--mem=65536M"),
        *("--partition=long", "--account=group-7", "--export=NONE", "--no-kill"),
    } <= set(found)
    assert "run ant --out 'my runs/one' --executor ray --ray-address" in script
    assert script.index("--head") < script.index("'/k e/y.env'") < script.index("run ant")
    assert subprocess.run(["bash", "-n"], input=script, text=True).returncode == 0
    with pytest.raises(InputError, match="is no name"):
        Allocation(nodes=1, seconds=600, partition="a; rm -rf /").directives()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--nodes", "0", "--time", "1h", "--", "run", "ant"), "nodes"),
        (("--nodes", "1", "--time", "soon", "--", "run", "ant"), "is no time"),
        (("--nodes", "1", "--time", "30s", "--", "run", "ant"), "give at least 5m"),
        (
            ("--nodes", "1", "--time", "1h", "--memory-per-node", "100K", "--", "run", "ant"),
            "--memory-per-node of 0.0977 MiB: Ray and one evaluation need more; give at least 1GiB",
        ),
        (("--nodes", "1", "--time", "1h"), "name the command"),
        (("--nodes", "1", "--time", "1h", "--", "show", "runs/demo"), "name the command"),
        (("--nodes", "1", "--time", "1h", "--", "run", "ant", "--executor", "ray"), "leave out"),
        (
            ("--nodes", "1", "--time", "1h", "--keys", "/no/file", "--", "run", "ant"),
            "no such file",
        ),
    ],
)
def test_what_cannot_be_is_refused(
    words: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cluster", "slurm", *words]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.skipif(bool(lacking()), reason=f"no Slurm here: {lacking()}")
@pytest.mark.skipif(find_spec("ray") is None, reason="needs the extra ray")
def test_it_runs_under_slurm_and_slurm_sees_no_key(tmp_path: Path) -> None:
    folder = tmp_path / "slurm"
    folder.mkdir()
    keys = tmp_path / "keys.env"
    keys.write_text("OPENAI_API_KEY=planted-for-the-command\n")
    script, out = tmp_path / "job.sh", tmp_path / "run"
    words = ["cluster", "slurm", "--nodes", "1", "--time", "30m", "--cores-per-node", "1"]
    words += ["--keys", str(keys), "--out", str(script), "--", *TINY, "--out", str(out)]
    assert main(words) == 0
    # Ray lets its workers give way to all else on a machine, and this one has other work.
    text = script.read_text()
    assert text.count("STATS_ENABLED=0\n") == text.count("pass+=,python,port,ip\n") == 1
    text = text.replace("STATS_ENABLED=0\n", "STATS_ENABLED=0 RAY_worker_niceness=0\n")
    script.write_text(text.replace("port,ip\n", "port,ip,RAY_worker_niceness\n"))
    with slurm(folder) as environment:
        done = subprocess.run(
            ["sbatch", "--wait", str(script)],
            cwd=tmp_path,
            env=environment | {"OPENAI_API_KEY": "planted-at-submission"},
            timeout=900,
        )
        said = "".join(log.read_text() for log in tmp_path.glob("robomore-*.log"))
        assert done.returncode == 0, said
    run = load_run(out)
    assert run.final and run.champion is not None
    for file in folder.rglob("*"):
        if file.is_file():
            assert b"planted" not in file.read_bytes(), file
    assert not list(Path("/tmp").glob("ray-[0-9]*")), "temporary files are left"
