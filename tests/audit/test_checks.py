"""What each check measures, on robots that nobody trained."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from audit.planted import restless, short, still
from robomore.audit import (
    Variant,
    bounds,
    density,
    integrator,
    matter,
    motors,
    noise,
    penetration,
    pushes,
    saturation,
    seeds,
    self_collision,
    support,
    timestep,
)
from robomore.audit.all_checks import CHECKS, audit
from robomore.audit.ground import Ground
from robomore.audit.overlap import Overlap
from robomore.audit.variant import VariedEnv
from robomore.envs.compile import compile_model
from robomore.tasks import get_task

STEPS = 20


def varied(variant: Variant, task: str = "half-cheetah") -> VariedEnv:
    chosen = short(task, STEPS)
    return VariedEnv(chosen, chosen.reference, 1, variant)


def thin(task: str, radius: float) -> tuple[float, ...]:
    """Return the reference morphology with all radii at `radius` m."""
    return tuple(radius if "radius" in p.name else p.reference for p in get_task(task).parameters)


def test_a_variant_changes_one_thing_and_no_control_step() -> None:
    plain = varied(Variant())
    finer = varied(Variant(timestep_division=2))
    assert finer.model.opt.timestep == plain.model.opt.timestep / 2
    assert finer.environment.dt == plain.environment.dt
    heavy = varied(Variant(mass=1.2))
    assert heavy.model.body_subtreemass[1] == pytest.approx(1.2 * plain.model.body_subtreemass[1])
    weak = varied(Variant(friction=0.5))
    assert np.allclose(weak.model.geom_friction[:, 0], 0.5 * plain.model.geom_friction[:, 0])
    other = varied(Variant(integrator="RK4", solver="CG")).model.opt
    assert (other.integrator, other.solver) != (
        plain.model.opt.integrator,
        plain.model.opt.solver,
    )


SERVO = '<position gear="1" kp="40" ctrlrange="-2.094 2.094" {} joint'


@pytest.mark.parametrize("actuator", ["<motor joint", SERVO.format('forcerange="-20 20"')])
@pytest.mark.parametrize("control", [0.1, 1.0])
def test_a_weak_motor_gives_less_force_and_a_weak_servo_holds_the_same_angle(
    actuator: str, control: float
) -> None:
    task = short("swimmer", STEPS)
    task = replace(task, template=task.template.replace("<motor joint", actuator))
    forces = []
    for factor in (1.0, 0.8):
        env = VariedEnv(task, task.reference, 1, Variant(motors=factor))
        env.reset_one(0, 0)
        (data,) = env.data
        data.qpos[-2:], data.qvel[:] = 0.05, 0.0
        data.ctrl[:] = control
        mujoco.mj_forward(env.model, data)
        forces.append(data.qfrc_actuator[-2:].copy())
        if "position" in actuator:
            data.ctrl[:] = 0.05
            mujoco.mj_forward(env.model, data)
            assert not data.qfrc_actuator.any()
    assert forces[0].all() and np.allclose(forces[1], 0.8 * forces[0])


def test_half_a_timestep_takes_the_same_time_and_is_measured_once() -> None:
    subject = restless(short("half-cheetah", STEPS))
    found = subject.measured(Variant(timestep_division=2))
    assert found is not None and found is subject.measured(Variant(timestep_division=2))
    assert found.behaviour["episode_seconds"] == pytest.approx(0.05 * STEPS)
    assert found.fitness != subject.measured().fitness  # type: ignore[union-attr]


def test_a_push_moves_a_robot_and_ends() -> None:
    subject = still(short("swimmer", 80))
    pushed, base = subject.worth(Variant(push=5.0)), subject.worth()
    assert pushed is not None and base is not None and pushed < base - 0.05
    env = VariedEnv(subject.task, subject.parameters, 1, Variant(push=1.0))
    env.reset_one(0, 0)
    forces = []
    for _ in range(60):
        env.step(np.zeros((1, env.action_size)))
        forces.append(env.data[0].xfrc_applied[1, 0])
    pushed_for = round(0.1 / env.environment.dt)
    assert [force != 0 for force in forces] == [50 <= n < 50 + pushed_for for n in range(60)]


def test_noise_is_the_same_in_each_audit_and_changes_the_motion() -> None:
    task = short("half-cheetah", STEPS)
    noisy = Variant(observation_noise=0.1)
    one, other = restless(task), restless(task)
    assert one.worth(noisy) == other.worth(noisy) != one.worth()


def test_robustness_warns_and_never_fails() -> None:
    subject = restless(short("half-cheetah", 40))
    subject._measured[Variant()] = replace(
        subject.measured(),  # type: ignore[type-var]
        fitness=1000.0,
    )
    for check in (noise.check, pushes.check, matter.check):
        assert check(subject).outcome == "warns"
    for check in (timestep.check, integrator.check):
        verdict = check(subject)
        assert verdict.outcome == "fails" and verdict.numbers["base"] == 1000.0


@pytest.mark.parametrize(
    ("worths", "outcome", "least"),
    [
        ((0.2, 1.0), "fails", 0.2),
        ((1.0, 0.49), "fails", 0.49),
        ((1.0, 0.51), "warns", 0.51),
        ((1.0, 0.69), "warns", 0.69),
        ((0.71, 1.0), "passes", 0.71),
        ((1.0, None), "fails", 0.0),
    ],
)
def test_the_variant_that_costs_most_decides(
    worths: tuple[float | None, ...], outcome: str, least: float
) -> None:
    subject = restless(short("half-cheetah", STEPS))
    plain = replace(subject.measured(), fitness=10.0)  # type: ignore[type-var]
    subject._measured[Variant()] = plain
    variants = (Variant(integrator="RK4"), Variant(solver="CG"))
    for variant, worth in zip(variants, worths, strict=True):
        left = None if worth is None else replace(plain, fitness=10 * worth)
        subject._measured[variant] = left
    verdict = integrator.check(subject)
    assert verdict.outcome == outcome
    assert verdict.numbers["least_left"] == pytest.approx(least)


def test_what_only_other_numbers_make_large_is_a_warning() -> None:
    subject = restless(short("half-cheetah", STEPS))
    subject._measured[Variant()] = replace(subject.measured(), fitness=1.0)  # type: ignore[type-var]
    doubled = replace(subject.measured(), fitness=2.1)  # type: ignore[type-var]
    same = replace(subject.measured(), fitness=1.9)  # type: ignore[type-var]
    for variant in (Variant(integrator="RK4"), Variant(solver="CG"), Variant(timestep_division=2)):
        subject._measured[variant] = doubled
    assert integrator.check(subject).outcome == timestep.check(subject).outcome == "warns"
    for variant in (Variant(integrator="RK4"), Variant(solver="CG"), Variant(timestep_division=2)):
        subject._measured[variant] = same
    assert integrator.check(subject).outcome == timestep.check(subject).outcome == "passes"


@pytest.mark.parametrize(
    ("task", "told"),
    [
        ("half-cheetah", "integrator RK4 "),
        ("swimmer", "integrator IMPLICITFAST at half the timestep "),
    ],
)
def test_rk4_is_compared_with_a_finer_first_order(task: str, told: str) -> None:
    subject = restless(short(task, STEPS))
    subject._measured[Variant()] = replace(subject.measured(), fitness=1.0)  # type: ignore[type-var]
    assert told in integrator.check(subject).says


def test_a_robot_that_gets_nowhere_has_nothing_to_lose() -> None:
    verdict = timestep.check(still(short("half-cheetah", STEPS)))
    assert verdict.outcome == "skipped" and "nothing to lose" in verdict.says


def test_the_fitness_that_a_run_tells_is_measured_again() -> None:
    task = short("half-cheetah", STEPS)
    measured = restless(task).measured()
    assert measured is not None
    assert seeds.check(restless(task, reported=measured.fitness)).outcome == "passes"
    verdict = seeds.check(restless(task, reported=abs(measured.fitness) * 10 + 1))
    assert verdict.outcome == "fails" and "the run tells" in verdict.says


def test_a_number_that_nothing_tells_is_not_compared() -> None:
    assert seeds.check(restless(short("half-cheetah", STEPS))).outcome == "skipped"


def test_a_jump_is_compared_by_what_it_adds_to_the_height_at_rest() -> None:
    subject = still(short("ant-jump", STEPS))
    found, gain = subject.measured(), subject.worth()
    assert found is not None and gain is not None and gain < 0.2 < found.fitness
    subject.reported = found.fitness + 3 * gain
    verdict = seeds.check(subject)
    assert found.fitness > 0.5 * subject.reported
    assert verdict.outcome == "fails" and "its height at rest" in verdict.says


def test_density_and_motors_of_a_thin_robot() -> None:
    task = short("half-cheetah", STEPS)
    for radius, outcome in ((0.046, "passes"), (0.01, "warns"), (0.006, "fails")):
        subject = replace(still(task), parameters=thin("half-cheetah", radius))
        assert density.check(subject).outcome == outcome, radius
    told = density.equal_density(subject)
    assert told["density"] == pytest.approx(660.9, abs=0.1)
    assert told["mass"] == pytest.approx(told["density"] * subject.facts["volume"])
    ant = short("ant", STEPS)
    light = replace(still(ant), parameters=thin("ant", 0.006))
    verdict = motors.check(light)
    assert verdict.outcome == "warns" and verdict.numbers["times_reference"] > 100
    assert motors.check(still(ant)).outcome == "passes"


def test_the_strength_of_a_servo_is_its_force_and_not_its_range() -> None:
    task = short("swimmer", STEPS)
    limited, free = (
        replace(task, template=task.template.replace("<motor joint", SERVO.format(limit)))
        for limit in ('forcerange="-20 20"', "")
    )
    verdict = motors.check(still(limited))
    assert verdict.numbers["torque_nm"] == 20.0 and verdict.says.startswith(
        "The strongest motor has 20"
    )
    assert motors.check(still(free)).outcome == "skipped"


def test_bounds_are_named() -> None:
    task = short("swimmer", STEPS)
    first, *others = task.parameters
    longest = (first.high, *(one.reference for one in others))
    verdict = bounds.check(replace(still(task), parameters=longest))
    assert verdict.outcome == "warns"
    assert f"1 of 6 parameters stand at a bound of the task: {first.name}" in verdict.says
    assert bounds.check(still(task)).outcome == "passes"


def test_full_force_is_saturation() -> None:
    subject = still(short("swimmer", STEPS))
    policy = replace(subject.policy, biases=(np.full(2, 9.0, np.float32),))
    assert saturation.check(replace(subject, policy=policy)).outcome == "warns"
    assert saturation.check(subject).outcome == "passes"


def test_what_a_robot_stands_on() -> None:
    subject = still(short("half-cheetah", STEPS))
    seen = subject.inspection
    assert seen is not None and seen.support["bfoot"] + seen.support["ffoot"] > 0.99
    assert support.check(subject).outcome == "passes"
    fallen = replace(seen, support={"head": 0.4, "bfoot": 0.6})
    object.__setattr__(subject, "inspection", fallen)
    verdict = support.check(subject)
    assert verdict.outcome == "warns" and "torso and head carry 40 %" in verdict.says
    # An Ant's first limbs are bodies of their own, and fixed to its torso.
    ant = still(short("ant", STEPS))
    object.__setattr__(ant, "inspection", replace(seen, support={"aux_1_geom": 0.5}))
    assert support.check(ant).numbers["torso_share"] == 0.5


def test_limbs_that_pass_through_each_other() -> None:
    subject = still(short("half-cheetah", STEPS))
    seen = subject.inspection
    assert seen is not None and seen.overlap_is_off and seen.overlap_share == 0
    assert self_collision.check(subject).outcome == "passes"
    model = compile_model(subject.task, subject.parameters)
    data, overlap = mujoco.MjData(model), Overlap(model)
    data.qpos[model.joint("bthigh").qposadr[0]] = -1.6  # the back leg lies along the torso
    mujoco.mj_forward(model, data)
    for _ in range(8):
        overlap.look(data)
    assert overlap.share == 1 and "torso" in overlap.worst
    object.__setattr__(subject, "inspection", replace(seen, overlap_share=0.2))
    assert self_collision.check(subject).outcome == "warns"
    assert self_collision.check(still(short("hopper", STEPS))).outcome == "skipped"


def test_a_task_without_a_ground() -> None:
    subject = still(short("swimmer", STEPS))
    assert penetration.check(subject).outcome == support.check(subject).outcome == "skipped"


def test_a_robot_that_stays_above_the_ground_is_told_as_that() -> None:
    subject = still(short("ant", 1))
    seen = subject.inspection
    assert seen is not None and seen.has_ground and not seen.support
    assert support.check(subject).says == "The robot never touched the ground."
    assert penetration.check(subject).says == "No limb goes into the ground."


def test_the_height_of_a_desert_is_that_of_the_simulation() -> None:
    task = get_task("ant-desert")
    model = compile_model(task, task.reference)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    ground = Ground(task, model)
    group = np.ones(6, np.uint8)
    hit = np.zeros(1, np.int32)
    for x, y in ((3.0, 4.0), (-7.3, 11.2), (40.5, -2.0)):
        start = np.array([x, y, 10.0])
        down = np.array([0.0, 0.0, -1.0])
        reach = mujoco.mj_ray(model, data, start, down, group, 1, -1, hit)
        height = float(ground._height(start[None])[0])
        assert height == pytest.approx(10.0 - reach, abs=0.02)


def test_an_audit_has_a_verdict_of_each_check() -> None:
    found = audit(restless(short("half-cheetah", STEPS)))
    assert len(found.verdicts) == len(CHECKS) == len({one.check for one in found.verdicts})
    assert all(one.says.endswith(".") for one in found.verdicts)
    assert found.passes == (not found.failed)
    assert found.equal_density["fitness"] == found.fitness
