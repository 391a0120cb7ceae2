"""A task as one frozen value: the robot with free dimensions, and what is to be done with it.

No MuJoCo here: reading a task, checking parameters, filling the MJCF template and computing the
volume cost nothing and work on a machine without a simulator.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from robomore.errors import InputError, InvalidMorphology
from robomore.suggestions import did_you_mean
from robomore.tasks.fitness import Fitness, as_fitness
from robomore.tasks.geometry import Shape
from robomore.tasks.repeats import expanded, indices
from robomore.tasks.solids import solids
from robomore.tasks.template import fill, names_used

_MESH_SCALE = re.compile(r'(<mesh\b[^>]*) scale="[^"]*\{[^"]*"')

_FILE = re.compile(r"""<(?!compiler)\w+\b[^>]*\sfile=["']([^"']+)""")

Values = Mapping[str, float]
"""Parameters by name."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One free dimension of a robot.

    Attributes:
        name: as it stands in the template and in parameter files.
        low: smallest allowed value, in `unit`.
        high: largest allowed value, in `unit`.
        reference: the value to compare with: that of the robot which people made, such as
            Gymnasium's, if there is one (never shown to a designer).
        meaning: one line for designers and people.
        unit: SI unit.
        scale: how a search should step through the range; `log` for sizes that span decades.
        search: lowest and highest value that samplers draw; `None` for all that is allowed. What a
            designer or a person proposes is not held to it.
        whole: whether only whole numbers are allowed, for a count.
    """

    name: str
    low: float
    high: float
    reference: float
    meaning: str
    unit: str = "m"
    scale: Literal["linear", "log"] = "linear"
    search: tuple[float, float] | None = None
    whole: bool = False


@dataclass(frozen=True, slots=True)
class Rule:
    """A condition between parameters, in words and as code.

    Attributes:
        text: the condition in words, shown to designers.
        violation: returns `None`, or what is wrong with these values, naming them.
    """

    text: str
    violation: Callable[[Values], str | None]


@dataclass(frozen=True, slots=True)
class Terrain:
    """A generated height field (paper, Appendix "Robustness across Different Terrains").

    Attributes:
        seed: of the noise.
        height: highest elevation, in m.
        half_correlation: distance at which the elevation's correlation falls to one half, in m.
        slope: root-mean-square slope.
        mean: mean elevation as a fraction of `height`.
        deviation: standard deviation of the elevation as a fraction of `height`.
        friction: sliding friction, which takes priority over the robot's own.
    """

    seed: int
    height: float
    half_correlation: float
    slope: float
    mean: float
    deviation: float
    friction: float


@dataclass(frozen=True, slots=True)
class Task:
    """What is to be done, and the parametrised robot that is to do it.

    Attributes:
        id: name on the command line, e.g. `ant-desert`.
        version: raised when a change makes old results incomparable.
        title: name in reports.
        description: the task in words, shown to designers.
        fitness: what an episode is worth, the larger the better: the name of a measure
            (`robomore.tasks.measures`), such as `distance` or `height`, or a `Fitness` of several
            or of one's own. `goal` is the same as a `Fitness`.
        template: MJCF text whose `{...}` placeholders are arithmetic over parameter names and
            `constants`; parts may be repeated (`robomore.tasks.repeats`). The same text, unfilled,
            is what a designer sees.
        parameters: the free dimensions, in order.
        rules: conditions between parameters that refuse what cannot be simulated.
        search_rules: further conditions that samplers keep to, such as proportions that are worth
            trying. What a designer or a person proposes is not held to them.
        shapes: the solids that make up the robot, for its volume; `None` for those that the
            template describes.
        reward: source of the reference reward, `_get_rew(self, x_velocity, action)`.
        environment: `module:Class` of the environment (loaded only when something is simulated).
        options: constructor options of the environment, some of which depend on the morphology.
        constants: fixed numbers that the template refers to (never parameters).
        terrain: height field to run on, or `None` for flat ground.
        episode_steps: control steps of a full episode.
        assets: content of the mesh files that the template names, by name.
        mesh_volumes: enclosed volume of each mesh in m³ at scale 1, by name.
        mass: how the robot's mass follows from its size, in words.
        radii: names of the parameters that set radii; `None` for those that change a radius among
            the solids. Only spheres and capsules tell theirs.
    """

    id: str
    title: str
    description: str
    fitness: str | Fitness
    template: str
    parameters: tuple[Parameter, ...]
    reward: str
    environment: str
    shapes: Callable[[Values], tuple[Shape, ...]] | None = None
    options: Callable[[Values], dict[str, Any]] = field(default=lambda values: {})
    rules: tuple[Rule, ...] = ()
    search_rules: tuple[Rule, ...] = ()
    constants: Mapping[str, float] = field(default_factory=dict)
    terrain: Terrain | None = None
    episode_steps: int = 1000
    version: int = 1
    assets: Mapping[str, bytes] = field(default_factory=dict)
    mesh_volumes: Mapping[str, float] = field(default_factory=dict)
    mass: str = ""
    radii: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Refuse a fitness that is none, and a template with a name that nothing gives a value.

        Raises:
            InputError: naming the task and what may stand there.
        """
        known = {*self.names, *self.constants}
        try:
            as_fitness(self.fitness)
            unknown = sorted(names_used(self.template) - known - indices(self.template))
        except (InputError, ValueError) as error:
            raise InputError(f"{self.id}: {error}") from None
        files = [name for name in _FILE.findall(self.template) if name not in self.assets]
        if files:
            raise InputError(
                f"{self.id}: its template reads the file {files[0]!r}, which a training in its "
                "sandbox cannot; put the file's content into `assets` under that name, without a "
                "meshdir, or let `robomore new` make a task file"
            )
        if unknown:
            raise InputError(
                f"{self.id}: its template uses {', '.join(map(repr, unknown))}, which is neither a "
                f"parameter nor a constant; there are {', '.join(sorted(known)) or 'none'}"
            )

    @property
    def goal(self) -> Fitness:
        """What an episode is worth."""
        return as_fitness(self.fitness)

    @property
    def reference(self) -> tuple[float, ...]:
        """The reference parameters, in the task's order: of the robot that people made, if any."""
        return tuple(parameter.reference for parameter in self.parameters)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(parameter.name for parameter in self.parameters)

    def check(self, parameters: Sequence[float] | Mapping[str, float]) -> tuple[float, ...]:
        """Return `parameters` as floats in the task's order, or say what is wrong with them.

        Args:
            parameters: a sequence in the task's order, or a mapping by name.

        Raises:
            InvalidMorphology: naming each offending parameter, its value and its bounds.
        """
        values = self._in_order(parameters)
        faults = []
        for parameter, value in zip(self.parameters, values, strict=True):
            if not math.isfinite(value):
                faults.append(f"{parameter.name} = {value} is not a finite number")
            elif not parameter.low <= value <= parameter.high:
                faults.append(
                    f"{parameter.name} = {value:g} {parameter.unit} is outside "
                    f"[{parameter.low:g}, {parameter.high:g}]"
                )
            elif parameter.whole and value != round(value):
                faults.append(f"{parameter.name} = {value:g} is a count; give a whole number")
        if not faults:
            named = dict(zip(self.names, values, strict=True))
            faults = [fault for rule in self.rules if (fault := rule.violation(named))]
        if faults:
            raise InvalidMorphology(f"{self.id}: " + "; ".join(faults))
        return values

    def searched(self) -> Task:
        """Return the task as samplers see it: within the search ranges and the search rules.

        Bounds wide enough for every idea of a designer would ruin a sampler: nearly all points
        between them are robots that nobody would propose.
        """
        narrow = tuple(
            replace(one, low=one.search[0], high=one.search[1], search=None) if one.search else one
            for one in self.parameters
        )
        rules = (*self.rules, *self.search_rules)
        return replace(self, parameters=narrow, rules=rules, search_rules=())

    def named(self, parameters: Sequence[float] | Mapping[str, float]) -> dict[str, float]:
        """Return checked parameters by name."""
        return dict(zip(self.names, self.check(parameters), strict=True))

    def volume(self, parameters: Sequence[float] | Mapping[str, float]) -> float:
        """Return the sum of the shapes' volumes in m³, overlaps counted twice (the paper's V)."""
        return sum(shape.volume for shape in self.solids(self.named(parameters)))

    def solids(self, values: Values) -> tuple[Shape, ...]:
        """Return the solids that make up the robot, for parameters by name, valid or not."""
        if self.shapes is not None:
            return self.shapes(values)
        values = {**self.constants, **values}
        with self._arithmetic():
            return solids(expanded(self.template, values), values, self.mesh_volumes)

    def mjcf(self, parameters: Sequence[float] | Mapping[str, float]) -> str:
        """Return the MJCF text of one morphology, without a terrain's elevations."""
        values = {**self.constants, **self.named(parameters)}
        with self._arithmetic():
            return fill(expanded(self.template, values), values)

    @property
    def masked_mjcf(self) -> str:
        """MJCF text as designers see it: parameters as placeholders, constants as numbers."""
        kept = {*self.names, *indices(self.template)}
        text = fill(self.template, dict(self.constants), keep=kept)
        # How much a mesh is scaled tells how large it is in its file.
        return _MESH_SCALE.sub(r'\1 scale="follows the parameters"', text)

    @contextmanager
    def _arithmetic(self) -> Iterator[None]:
        """Name what is wrong where the template has no value for some parameters."""
        try:
            yield
        except (ArithmeticError, ValueError, TypeError, KeyError, RecursionError) as error:
            said = f"its template has no value for these parameters ({str(error)[:200]})"
            raise InvalidMorphology(f"{self.id}: {said}") from None

    def _in_order(self, parameters: Sequence[float] | Mapping[str, float]) -> tuple[float, ...]:
        if isinstance(parameters, Mapping):
            unknown = sorted(set(parameters) - set(self.names))
            missing = [name for name in self.names if name not in parameters]
            if unknown or missing:
                said = [f"unknown {', '.join(map(repr, unknown))}"] if unknown else []
                said += [f"missing {', '.join(missing)}"] if missing else []
                raise InvalidMorphology(
                    f"{self.id}: {' and '.join(said)}."
                    f"{did_you_mean(unknown[0], missing) if unknown else ''} It takes "
                    f"{', '.join(self.names)}"
                )
            parameters = [parameters[name] for name in self.names]
        if isinstance(parameters, str | bytes) or not hasattr(parameters, "__len__"):
            raise InvalidMorphology(
                f"{self.id}: the parameters are {parameters!r}; give {len(self.names)} numbers in "
                f"the order {', '.join(self.names)}, or a mapping of these names"
            )
        if len(parameters) != len(self.parameters):
            raise InvalidMorphology(
                f"{self.id}: {len(parameters)} parameters given, it takes {len(self.parameters)} "
                f"({', '.join(self.names)})"
            )
        try:
            return tuple(float(value) for value in parameters)
        except (TypeError, ValueError, OverflowError) as error:
            raise InvalidMorphology(f"{self.id}: a parameter is not a number ({error})") from None


def with_counts(task: Task, counts: Sequence[float]) -> Task:
    """Return a task whose template has numbers in the place of its counts, and no repeats.

    Args:
        task: with parameters that are whole numbers.
        counts: values of these, in the task's order.
    """
    names = [one.name for one in task.parameters if one.whole]
    known = {**task.constants, **dict(zip(names, counts, strict=True))}
    template = fill(expanded(task.template, known), known, keep=set(task.names) - set(names))
    return replace(task, template=template)
