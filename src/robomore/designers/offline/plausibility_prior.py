"""A prior over morphologies: which are worth training before anything is known of them.

All measures are general. They read a morphology's solids and its rest pose, and know neither the
task nor the reference design. They are in units of log efficiency: one less means that the
efficiency is expected to be 2.7 times lower.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from robomore.designers.offline.batched_kinematics import BatchedKinematics
from robomore.designers.offline.rest_pose import RestPose
from robomore.tasks.geometry import Shape
from robomore.tasks.repeats import repeats
from robomore.tasks.task import Task, with_counts
from robomore.tasks.unit_space import UnitSpace

log = logging.getLogger(__name__)

Array = NDArray[np.float64]

VOLUME_GAIN = 1.0
"""Log efficiency that 1/e of the volume gains, which is what it gains at equal speed. Thinner
reference designs of Half-Cheetah, Hopper and Swimmer ran as far or farther, one training each; Ant
and Walker learnt too little in those 20,000 steps to tell."""
STRIDE_GAIN = 2.0
"""Log efficiency that legs of e times the length gain, up to `LEG_LENGTHS[0]`: longer strides."""
LEG_LENGTHS = (1.2, 2.0)
"""Length in m of a leg's moving limbs above which a robot gains nothing, and above which one that
stands loses, because motors of fixed strength swing long legs slowly."""
SLENDERNESS = (1.5, 200.0)
"""Plausible range of a limb's length over its radius. Below are balls, above are needles."""
MAX_LENGTH_SPREAD, MAX_RADIUS_SPREAD = 0.5, 0.4
"""Largest plausible standard deviation of the logarithm over the limbs of one morphology."""
MAX_FOLDING = 1.5
"""Largest plausible ratio of a leg's length along its limbs to the distance between its ends."""
MAX_DROP = 0.2
"""Largest plausible height in which a robot starts above the ground, as a fraction of its own."""
LOW_HEIGHT = 0.3
"""A morphology whose height is below this fraction of its reach lies rather than stands."""


class PlausibilityPrior:
    """Rates morphologies of one task without simulating them.

    Where the number of parts is free, robots of equal numbers are rated together.
    """

    def __init__(self, task: Task) -> None:
        self._of_structure: dict[tuple[float, ...], PlausibilityPrior] = {}
        self._task = task
        self._space = UnitSpace(task)
        self._kinematics: BatchedKinematics | None = None
        if repeats(task.template):
            return
        try:
            self._kinematics = BatchedKinematics(task.template, task.constants)
        except ValueError as error:
            # A robot of a third party may use features that `BatchedKinematics` does not read.
            # Then only the solids are rated.
            log.info("%s: morphologies are rated without their rest pose: %s", task.id, error)

    def log_efficiency(self, values: Array) -> Array:
        """Return the expected log efficiency (n,), up to a constant, of valid rows (n, size)."""
        if repeats(self._task.template):
            return self._by_structure(values, PlausibilityPrior.log_efficiency)
        lengths, radii, volumes = self._solids(values)
        merit = -VOLUME_GAIN * np.log(volumes) - self._penalty_of_solids(values, lengths, radii)
        if (pose := self._rest_pose(values)) is not None:
            # Limbs that lie flat, such as a long foot, carry a standing robot no higher.
            upright = np.where(pose.height > 1e-6, pose.height, np.inf)
            strides = np.clip(np.minimum(pose.stride, upright), 0.01, LEG_LENGTHS[0])
            merit += STRIDE_GAIN * np.log(strides) - _penalty_of_pose(pose)
        return merit

    def penalty(self, values: Array) -> Array:
        """Return the log efficiency (n,) >= 0 that the shapes of valid rows (n, size) cost.

        Volume and size do not count.
        """
        if repeats(self._task.template):
            return self._by_structure(values, PlausibilityPrior.penalty)
        lengths, radii, _ = self._solids(values)
        penalty = self._penalty_of_solids(values, lengths, radii)
        if (pose := self._rest_pose(values)) is not None:
            penalty += _penalty_of_pose(pose)
        return penalty

    def _by_structure(
        self, values: Array, rate: Callable[[PlausibilityPrior, Array], Array]
    ) -> Array:
        whole = [index for index, one in enumerate(self._task.parameters) if one.whole]
        found = np.empty(len(values))
        for counts in {tuple(row) for row in values[:, whole].tolist()}:
            if counts not in self._of_structure:
                self._of_structure[counts] = PlausibilityPrior(with_counts(self._task, counts))
            alike = (values[:, whole] == counts).all(axis=1)
            found[alike] = rate(self._of_structure[counts], values[alike])
        return found

    def _rest_pose(self, values: Array) -> RestPose | None:
        if self._kinematics is None:
            return None
        columns = dict(zip(self._task.names, np.asarray(values, dtype=float).T, strict=True))
        return self._kinematics.rest_pose(columns)

    def _shapes(self, values: Array) -> Sequence[Shape]:
        # Unlike `Task.named`, this takes values that break the task's rules.
        return self._task.solids(dict(zip(self._task.names, values.tolist(), strict=True)))

    def _solids(self, values: Array) -> tuple[Array, Array, Array]:
        """Return lengths (n, p) in m (0 for balls), radii (n, p) in m and volumes (n,) in m³."""
        robots = [self._shapes(row) for row in np.asarray(values, dtype=float)]
        lengths = [[getattr(shape, "length", 0.0) for shape in shapes] for shapes in robots]
        radii = [[shape.radius for shape in shapes] for shapes in robots]
        volumes = [sum(shape.volume for shape in shapes) for shapes in robots]
        return np.array(lengths), np.array(radii), np.array(volumes)

    def _penalty_of_solids(self, values: Array, lengths: Array, radii: Array) -> Array:
        penalty: Array = 2 * np.maximum(np.log(radii).std(axis=1) - MAX_RADIUS_SPREAD, 0)
        limbs = (lengths > 0).all(axis=0)
        if limbs.any():
            lengths, radii = lengths[:, limbs], radii[:, limbs]
            penalty += _outside(lengths / radii, *SLENDERNESS).mean(axis=1)
            penalty += 2 * np.maximum(np.log(lengths).std(axis=1) - MAX_LENGTH_SPREAD, 0)
        return penalty


def _penalty_of_pose(pose: RestPose) -> Array:
    stands = pose.height > 1e-6
    lies = np.maximum(LOW_HEIGHT - pose.height / pose.reach, 0) / LOW_HEIGHT
    too_long = STRIDE_GAIN * np.maximum(np.log(pose.stride / LEG_LENGTHS[1]), 0)
    penalty: Array = (
        -2 * np.log(pose.leverage)
        + 4 * np.minimum(pose.overhang, 1)
        + 3 * np.minimum(pose.tilt, 1)
        + 3 * np.maximum(np.log(pose.folding / MAX_FOLDING), 0)
        + np.where(stands, too_long + 2 * lies + 4 * np.clip(pose.drop - MAX_DROP, 0, 1), 0)
    )
    return penalty


def _outside(values: Array, low: float, high: float) -> Array:
    """Return the logarithm of the factor by which `values` lie outside of [low, high]."""
    logs = np.log(np.maximum(values, 1e-9))
    excess: Array = np.maximum(np.log(low) - logs, 0) + np.maximum(logs - np.log(high), 0)
    return excess
