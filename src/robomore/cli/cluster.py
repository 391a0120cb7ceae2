"""`robomore cluster`: what a cluster needs to run RoboMoRe."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from robomore.cli.inputs import positive, read_bytes, read_duration
from robomore.cli.output import tell, write
from robomore.cli.whole import Whole
from robomore.errors import InputError


def cluster(
    kind: Literal["slurm"],
    /,
    *command: Annotated[str, Parameter(allow_leading_hyphen=True)],
    nodes: Whole,
    time: str,
    cores_per_node: Whole | None = None,
    memory_per_node: str | None = None,
    partition: str = "",
    account: str = "",
    keys: Path | None = None,
    out: Path | None = None,
) -> None:
    """Write the batch script that runs a command on a Ray cluster in an allocation of Slurm.

    For example: `robomore cluster slurm --nodes 4 --time 8h -- run ant --preset standard`

    Parameters
    ----------
    kind
        The scheduler: `slurm`.
    command
        The command after `--`, without the word `robomore` and without `--executor`.
    nodes
        Machines.
    time
        Wall-clock limit: `30m` or `8h`. Two minutes before its end the command stops in good
        order; the same script, submitted again, goes on.
    cores_per_node
        Processor cores of each machine; by default whole machines are asked for.
    memory_per_node
        Memory of each machine: `64GiB`.
    partition
        The queue.
    account
        Who pays.
    keys
        File with lines NAME=VALUE, for the keys of language models. Only the command reads it, on
        the first machine.
    out
        File to write the script to; by default it is printed.
    """
    from robomore.executors.slurm import Allocation, sbatch_script

    positive(nodes=nodes, cores_per_node=cores_per_node)
    if not command or command[0] not in ("run", "study"):
        raise InputError(
            "name the command that the cluster is for after `--`: run or study, for example "
            "`-- run ant --preset standard`"
        )
    if any(word.startswith(("--executor", "--ray-address")) for word in command):
        raise InputError("leave out --executor and --ray-address; the script adds them")
    if keys is not None and not keys.is_file():
        raise InputError(f"--keys {keys}: there is no such file")
    allocation = Allocation(
        nodes=nodes,
        seconds=read_duration("time", time),
        cores_per_node=cores_per_node,
        memory_per_node=(
            read_bytes("memory-per-node", memory_per_node) if memory_per_node else None
        ),
        partition=partition,
        account=account,
    )
    script = sbatch_script(allocation, command, keys)
    if out is None:
        write(script)
        return
    try:
        out.write_text(script)
    except OSError as error:
        raise InputError(f"cannot write to {out} ({error.strerror}); name another --out") from None
    tell(f"submit it with: sbatch {out}\n")
