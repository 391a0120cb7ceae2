"""The options of `robomore run`, group by group, and the settings that they stand for."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from robomore.cli.completion import METHOD, PRESET
from robomore.cli.inputs import positive, read_bytes, read_duration, read_options
from robomore.cli.whole import Whole
from robomore.errors import InputError

if TYPE_CHECKING:
    from robomore.executors import Executor
    from robomore.executors.resources import Resources
    from robomore.settings import RunSettings

RAY = "ray"

DEFAULT_PRESET = "quick"

Pairs = Annotated[list[str] | None, Parameter(negative="")]


@Parameter(name="*", group=Group("Search", sort_key=1))
@dataclass(frozen=True, kw_only=True)
class Search:
    """What is tried, and how much of it.

    Attributes
    ----------
    preset
        `smoke` (about a minute), `quick` (some minutes on two cores), `standard` or `paper`.
    method
        The search method, `robomore` by default. `robomore methods` lists all of them.
    method_option
        One option of the method, as NAME=VALUE: `morphologies=10`. May be given several times.
    reference_reward
        Short for `--method-option reference_reward=…`: `in` makes the reference reward one column
        of the grid, `out` leaves it out, as the paper does.
    objective
        What is compared: `efficiency` (fitness / volume, as in the paper), `fitness`, or
        `transport-economy` (1 / cost of transport).
    max_volume
        Largest volume of a design, in m³.
    max_density
        Largest mass divided by volume, in kg/m³.
    evaluations
        About how many full trainings the search may use, for methods without sizes of their own.
    budget_steps
        Control steps of training that the search may use. The final comes on top.
    start_from
        What the search starts from besides the reference design: a JSON file with parameters, a
        Python file with a reward, the folder of a run (its champion) or of a design, or the word
        `reference` or `slim-reference` (the reference with its radii at their thinnest). May be
        given several times.
    time_limit
        Time after which nothing new is started: `90s`, `30m` or `2h`. The run then ends with the
        best so far, and the same command goes on later.
    """

    preset: Annotated[str, PRESET] = DEFAULT_PRESET
    method: Annotated[str | None, METHOD] = None
    method_option: Pairs = None
    reference_reward: Literal["in", "out"] | None = None
    objective: Literal["efficiency", "fitness", "transport-economy"] | None = None
    max_volume: float | None = None
    max_density: float | None = None
    evaluations: Whole | None = None
    budget_steps: Whole | None = None
    start_from: Pairs = None
    time_limit: str | None = None

    @property
    def seconds(self) -> float | None:
        """The time limit in seconds."""
        return None if self.time_limit is None else read_duration("time-limit", self.time_limit)


@Parameter(name="*", group=Group("Training", sort_key=2))
@dataclass(frozen=True, kw_only=True)
class Training:
    """How each design of the search is trained.

    Attributes
    ----------
    steps
        Control steps of training for each design.
    trainer
        The algorithm, with its own defaults: `crossq` (that of the presets), `sac` (the paper's
        algorithm and settings) or `sb3` (the same through Stable-Baselines3; needs the extra
        `sb3`).
    trainer_option
        One option of the trainer, as NAME=VALUE: `batch_size=512`, `net_arch=[256,256]`. May be
        given several times.
    """

    steps: Whole | None = None
    trainer: str | None = None
    trainer_option: Pairs = None


@Parameter(name="*", group=Group("Final", sort_key=3))
@dataclass(frozen=True, kw_only=True)
class Final:
    """How the best designs are compared with the reference design at the end.

    Attributes
    ----------
    final_steps
        Control steps of each training in the final. By default they change with `--steps`.
    finalists
        Number of designs from the search that are trained anew.
    final_seeds
        Training seeds of each design. Fewer than five give no interval.
    require_audit
        A design that fails its audit (see `robomore audit`) cannot be champion.
    """

    final_steps: Whole | None = None
    finalists: Whole | None = None
    final_seeds: Whole | None = None
    require_audit: Annotated[bool, Parameter(negative="")] = False


@Parameter(name="*", group=Group("Machine", sort_key=7))
@dataclass(frozen=True, kw_only=True)
class Machine:
    """Where the work is done, and where its files are kept.

    Attributes
    ----------
    workers
        Number of evaluations that run at the same time; by default one for each core.
    executor
        Where evaluations run: in worker `processes`, `inline` in this process, or on a `ray`
        cluster.
    ray_address
        The Ray cluster to use: `auto` for the one that this machine belongs to, or HOST:PORT.
        Without it, one is started on this machine for this command.
    cores
        Processor cores that a Ray cluster reserves for each evaluation.
    memory
        Memory that a Ray cluster reserves for each evaluation: `1GiB`.
    gpu_share
        GPUs that a Ray cluster reserves for each evaluation, or a share of one: 0.25.
    containment
        `strict` refuses to start if this machine does not offer all sandbox layers for rewards,
        `relaxed` runs with the layers that are available.
    out
        Folder of the run. By default it is made in `runs/` and named after the options.
    """

    workers: Whole | None = None
    executor: str = "processes"
    ray_address: str | None = None
    cores: float | None = None
    memory: str | None = None
    gpu_share: float | None = None
    containment: Literal["strict", "relaxed"] | None = None
    out: Path | None = None

    def check(self) -> None:
        """Refuse what cannot be used, before anything is started.

        Raises:
            InputError: naming the option.
        """
        from robomore.executors import EXECUTORS

        positive(workers=self.workers)
        EXECUTORS.get(self.executor)
        if self.executor == RAY:
            self._resources()
            return
        for name in ("ray_address", "cores", "memory", "gpu_share"):
            if getattr(self, name) is not None:
                option = name.replace("_", "-")
                raise InputError(
                    f"--{option} is for a Ray cluster; add --executor ray, or leave it out"
                )

    @contextmanager
    def opened(self) -> Iterator[str | Executor]:
        """Join the cluster while the context lasts, or give the name of an executor.

        Raises:
            InputError: the cluster cannot be used.
        """
        if self.executor != RAY:
            yield self.executor
            return
        from robomore.executors.ray import Ray

        with closing(Ray(self.workers, self.ray_address, self._resources())) as executor:
            yield executor

    def _resources(self) -> Resources:
        from robomore.executors.resources import Resources

        given: dict[str, Any] = {"cores": self.cores, "gpu_share": self.gpu_share}
        if self.memory is not None:
            given["memory_bytes"] = read_bytes("memory", self.memory)
        return Resources(**{name: value for name, value in given.items() if value is not None})


def settings_of(search: Search, training: Training, final: Final) -> RunSettings:
    """Return the preset's settings with the given options in place of its own.

    Raises:
        InputError: an option cannot be used.
    """
    from robomore.options import with_options
    from robomore.settings import preset

    plain = preset(search.preset)
    method_options = read_options("method-option", search.method_option, "morphologies=10")
    if search.reference_reward is not None:
        method_options["reference_reward"] = _with_reference_reward(
            search.method or plain.method.name, search.reference_reward
        )
    return with_options(
        plain,
        method=search.method,
        method_options=method_options,
        trainer=training.trainer,
        trainer_options=read_options("trainer-option", training.trainer_option, "batch_size=512"),
        steps=training.steps,
        final_steps=final.final_steps,
        finalists=final.finalists,
        final_seeds=final.final_seeds,
        require_audit=final.require_audit or None,
        evaluations=search.evaluations,
        objective=search.objective,
        max_volume=search.max_volume,
        max_density=search.max_density,
    )


def _with_reference_reward(method: str, value: str) -> str:
    """Return `value` if the method has that option.

    Raises:
        InputError: it has none.
    """
    from robomore.search import METHODS

    if "reference_reward" not in [field.name for field in fields(METHODS.get(method).Settings)]:
        raise InputError(f"the method {method!r} has no option reference_reward; leave it out")
    return value
