"""The batch script that starts a Ray cluster in an allocation of Slurm and runs a command on it.

This is how Ray documents its use with Slurm. Two things are added. The token is made for the job
alone, and reaches the nodes through Slurm's own channel, never through a command line or a shared
file. And the nodes inherit an allow-list of variables, so that an API key stays with the command.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robomore.errors import InputError

_TEMPLATE = """\
#!/bin/bash
#SBATCH --job-name=robomore
#SBATCH --output=robomore-%j.log
@directives@
# Nothing of the environment in which it was submitted: Slurm would keep a key in its spool.
#SBATCH --export=NONE
# One task a node, and the job outlives a node that fails.
#SBATCH --ntasks-per-node=1
#SBATCH --no-kill
# Two minutes before the time is up, the command stops in good order.
#SBATCH --signal=B:TERM@120

set -u
umask 077
cd -- "$SLURM_SUBMIT_DIR" || exit
export RAY_AUTH_MODE=token RAY_AUTH_TOKEN
RAY_AUTH_TOKEN=$(od -An -N32 -tx1 /dev/urandom | tr -d ' \\n')
export RAY_USAGE_STATS_ENABLED=0
# A network that is away for half a minute is no dead node.
export RAY_health_check_failure_threshold=20
export python=@python@ port=$((20000 + SLURM_JOB_ID % 10000)) ip
export PATH="@bin@:$PATH"
ip=$(getent ahostsv4 "$(hostname)" | awk '!/^127/ {print $1; exit}')
: "${ip:=$(hostname -I | awk '{print $1}')}"
mapfile -t nodes < <(scontrol show hostnames "$SLURM_JOB_NODELIST")

# The nodes get these variables and no others.
pass=PATH,HOME,LANG,USER,TMPDIR,LD_LIBRARY_PATH
pass+=,RAY_AUTH_MODE,RAY_AUTH_TOKEN,RAY_USAGE_STATS_ENABLED,RAY_health_check_failure_threshold
pass+=,python,port,ip
node() {
  srun --nodes=1 --ntasks=1 --nodelist="$1" --overlap --cpus-per-task="$SLURM_CPUS_ON_NODE" \\
    --export="$pass" bash -c 'exec "$python" -m ray.scripts.scripts start --block \\
      --disable-usage-stats --num-cpus="$SLURM_CPUS_ON_NODE" "$@" >/dev/null' "$@" &
}
steps=()
node "${nodes[0]}" --head --node-ip-address="$ip" --port="$port" --include-dashboard=false \\
  --dashboard-host=127.0.0.1 --temp-dir="/tmp/ray-$SLURM_JOB_ID"
steps+=($!)
up() { "$python" -m ray.scripts.scripts health-check --address "$ip:$port" >/dev/null 2>&1; }
for _ in {1..60}; do up && break; sleep 2; done
up || { echo "the Ray cluster did not start on ${nodes[0]}" >&2; kill "${steps[@]}"; exit 1; }
for name in "${nodes[@]:1}"; do
  node "$name" --address="$ip:$port"
  steps+=($!)
done
@keys@
@command@ --executor ray --ray-address "$ip:$port" &
driver=$!
trap 'kill -TERM "$driver"' TERM
wait "$driver"; status=$?
# A signal ends the wait and not yet the command.
while kill -0 "$driver" 2>/dev/null; do wait "$driver"; status=$?; done
kill "${steps[@]}" 2>/dev/null
wait "${steps[@]}" 2>/dev/null
timeout 60 srun --overlap --kill-on-bad-exit=0 --export=PATH rm -rf "/tmp/ray-$SLURM_JOB_ID"
exit "$status"
"""


_LEAST_SECONDS, _LEAST_MEMORY = 300, 2**30


@dataclass(frozen=True, slots=True, kw_only=True)
class Allocation:
    """What is asked of Slurm.

    Attributes:
        nodes: machines.
        seconds: wall-clock limit of the job, at least 300.
        cores_per_node: processor cores of each; `None` for whole machines.
        memory_per_node: bytes of each, at least 1 GiB; `None` for what the cluster gives by itself.
        partition: queue of the cluster; empty for its default.
        account: who pays; empty for the user's default.
    """

    nodes: int
    seconds: float
    cores_per_node: int | None = None
    memory_per_node: int | None = None
    partition: str = ""
    account: str = ""

    def directives(self) -> str:
        """Return the lines that ask for it.

        Raises:
            InputError: a value makes no sense.
        """
        for name, text in (("partition", self.partition), ("account", self.account)):
            if text != shlex.quote(text) and text:
                raise InputError(f"--{name} {text!r} is no name that Slurm knows")
        if self.seconds < _LEAST_SECONDS:
            raise InputError(
                f"--time of {self.seconds:g} s: the command is stopped two minutes before the end, "
                f"and Ray has to start; give at least {_LEAST_SECONDS // 60}m"
            )
        memory = self.memory_per_node
        if memory is not None and memory < _LEAST_MEMORY:
            raise InputError(
                f"--memory-per-node of {memory / 2**20:.3g} MiB: Ray and one evaluation need more; "
                f"give at least {_LEAST_MEMORY // 2**30}GiB"
            )
        minutes = round(self.seconds / 60)
        lines = [
            f"--nodes={self.nodes}",
            f"--time={minutes // 1440}-{minutes // 60 % 24:02}:{minutes % 60:02}:00",
            f"--cpus-per-task={self.cores_per_node}" if self.cores_per_node else "--exclusive",
        ]
        if memory:
            lines.append(f"--mem={memory // 2**20}M")
        if self.partition:
            lines.append(f"--partition={self.partition}")
        if self.account:
            lines.append(f"--account={self.account}")
        return "\n".join(f"#SBATCH {line}" for line in lines)


def sbatch_script(allocation: Allocation, command: Sequence[str], keys: Path | None = None) -> str:
    """Return a batch script that runs a `robomore` command on an allocation.

    Args:
        allocation: what is asked of Slurm.
        command: words after `robomore`, such as `("run", "ant")`, without `--executor`.
        keys: file with lines NAME=VALUE that only the command reads, for language models.

    Raises:
        InputError: a value makes no sense.
    """
    python = Path(sys.executable)
    read_keys = ""
    if keys is not None:
        file = shlex.quote(str(keys.absolute()))
        read_keys = f"# Read here, so that the nodes do not get them.\nset -a; . {file}; set +a\n"
    parts = {
        "directives": allocation.directives(),
        "python": shlex.quote(str(python)),
        "bin": str(python.parent),
        "keys": read_keys,
        "command": shlex.join([str(python), "-m", "robomore", *command]),
    }
    script = _TEMPLATE
    for name, value in parts.items():
        script = script.replace(f"@{name}@", value)
    return script
