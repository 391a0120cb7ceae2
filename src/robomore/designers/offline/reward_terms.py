"""The common reward terms of the field as readable Python, each with a range of weights."""

from __future__ import annotations

from robomore.designers.offline.reward_leads import FORWARD, UPWARD
from robomore.designers.offline.reward_term import Term
from robomore.designers.offline.robot_semantics import RobotSemantics


def suitable(robot: RobotSemantics) -> tuple[Term, ...]:
    """Return the terms that suit a robot and its task."""
    return tuple(term for term in TERMS.values() if term.suits(robot))


def _cost(
    name: str, idea: str, comment: str, code: str, low: float, high: float, topic: str
) -> Term:
    return Term(name, "cost", idea, comment, code, low, high, topic)


_SURVIVAL = (
    Term(
        "alive",
        "survival",
        "stay healthy",
        "A bonus for every step in which the robot has not fallen.",
        "alive = {w} * float({falls})",
        0.4,
        1.5,
        "survival",
    ),
)

_BONUSES = (
    Term(
        "upright",
        "bonus",
        "upright torso",
        "1 when the torso is as upright as at the start, -1 upside down.",
        "upright = {w} * ({up})",
        0.1,
        0.4,
        "posture",
    ),
    Term(
        "facing_ahead",
        "bonus",
        "straight heading",
        "1 when the torso points along the course.",
        "facing_ahead = {w} * ({heading})",
        0.1,
        0.4,
        "course",
    ),
    Term(
        "riding_height",
        "bonus",
        "constant torso height",
        "Keeps the torso near its starting height.",
        "riding_height = {w} * np.exp(-8.0 * np.square({height} - {rest}))",
        0.1,
        0.5,
        "height",
        goal="distance",
    ),
    Term(
        "hopping",
        "bonus",
        "hops",
        "A gait with a flight phase: up to half a metre above the starting height counts.",
        "hopping = {w} * np.clip({height} - {rest}, 0.0, 0.5)",
        0.3,
        1.5,
        "height",
        goal="distance",
    ),
    Term(
        "rolling",
        "bonus",
        "roll forward",
        "Forward rotation: robots with short limbs may move best by rolling.",
        "rolling = {w} * np.clip({tip}, -5.0, 5.0)",
        0.02,
        0.12,
        "posture",
        ("roll_free",),
        "distance",
    ),
    Term(
        "alternation",
        "bonus",
        "alternating legs",
        "The two hips should swing in opposite directions.",
        "alternation = {w} * np.tanh(-{hip_rate} * {other_hip_rate})",
        0.05,
        0.3,
        "gait",
        ("legs2",),
        "distance",
    ),
    Term(
        "stride",
        "bonus",
        "long strides",
        "Difference between the two hip angles, in rad.",
        "stride = {w} * np.abs({hip_angle} - {other_hip_angle})",
        0.1,
        0.4,
        "gait",
        ("legs2",),
        "distance",
    ),
    Term(
        "diagonal_gait",
        "bonus",
        "trot",
        "The two legs of a diagonal swing forward together.",
        "diagonal_gait = {w} * (np.tanh(-{hip1} * {hip3}) + np.tanh(-{hip2} * {hip4}))",
        0.03,
        0.2,
        "gait",
        goal="distance",
    ),
    Term(
        "joint_push_off",
        "bonus",
        "all legs push at once",
        "The hips stay still while the rest of the legs moves: one common push-off.",
        "hips = np.array([{hip1}, {hip2}, {hip3}, {hip4}])\n"
        "joint_push_off = {w} * np.exp(-np.mean(np.square(hips)))",
        0.1,
        0.4,
        "gait",
        goal="height",
    ),
    Term(
        "springy_knee",
        "bonus",
        "active knee",
        "A knee that bends and stretches fast drives the hop.",
        "springy_knee = {w} * np.tanh(0.3 * np.abs({knee_rate}))",
        0.1,
        0.4,
        "gait",
    ),
    Term(
        "travelling_wave",
        "bonus",
        "a wave from front to back",
        "A bend that moves from the front joint to the back joint pushes against the fluid.",
        "wave = {bend} * {next_bend_rate} - {next_bend} * {bend_rate}\n"
        "travelling_wave = {w} * np.tanh(wave)",
        0.05,
        0.4,
        "gait",
    ),
    Term(
        "activity",
        "bonus",
        "moving joints",
        "A small reward for motion of the joints, so that the robot does not stand still.",
        "activity = {w} * np.tanh(np.mean(np.abs({rates})) / 5.0)",
        0.1,
        0.5,
        "activity",
    ),
    Term(
        "whole_range",
        "bonus",
        "wide joint motion",
        "Spread of the joint angles, in rad.",
        "whole_range = {w} * np.tanh(np.std({angles}))",
        0.1,
        0.4,
        "activity",
    ),
)

_COSTS = (
    _cost(
        "effort",
        "little effort",
        "Squared torques, summed over the motors.",
        "effort = {w} * np.sum(np.square(action))",
        0.01,
        0.1,
        "effort",
    ),
    _cost(
        "strain",
        "little mean torque",
        "Mean absolute torque.",
        "strain = {w} * np.mean(np.abs(action))",
        0.05,
        0.4,
        "effort",
    ),
    _cost(
        "power",
        "little energy",
        "Mechanical power: torque times joint speed, summed over the motors.",
        "power = {w} * np.sum(np.abs(action * {rates}))",
        0.002,
        0.015,
        "effort",
    ),
    _cost(
        "saturation",
        "no motor at its limit",
        "Grows steeply when motors run near their limits.",
        "saturation = {w} * np.mean(np.power(action, 6))",
        0.05,
        0.4,
        "effort",
    ),
    _cost(
        "jerkiness",
        "smooth actions",
        "Change of the action since the last step.",
        'if not hasattr(self, "_last_action"):\n'
        "    self._last_action = np.zeros_like(action)\n"
        "jerkiness = {w} * np.sum(np.square(action - self._last_action))\n"
        "self._last_action = np.array(action)",
        0.01,
        0.06,
        "smoothness",
    ),
    _cost(
        "joint_speed",
        "slow joints",
        "Squared joint speeds.",
        "joint_speed = {w} * np.mean(np.square({rates}))",
        0.001,
        0.005,
        "smoothness",
    ),
    _cost(
        "hard_contact",
        "soft contacts",
        "Contact forces, clipped so that one impact does not dominate the reward.",
        "forces = np.clip({contacts}, -1.0, 1.0)\nhard_contact = {w} * np.sum(np.square(forces))",
        0.0002,
        0.002,
        "contact",
    ),
    Term(
        "bobbing",
        "cost",
        "little vertical motion",
        "Squared vertical speed, which does not help to move forward.",
        "bobbing = {w} * np.square({lift})",
        0.02,
        0.15,
        "height",
        goal="distance",
    ),
    _cost(
        "wobble",
        "steady torso",
        "Squared turning rate of the torso, in (rad/s)², up to a limit.",
        "wobble = {w} * np.minimum({spin}, 25.0)",
        0.004,
        0.03,
        "posture",
    ),
    _cost(
        "lean",
        "no leaning",
        "0 when upright, grows with the torso's angle.",
        "lean = {w} * (1.0 - ({up}))",
        0.2,
        0.8,
        "posture",
    ),
    _cost(
        "drift",
        "no sideways drift",
        "Speed across the course, in m/s.",
        "drift = {w} * np.abs({sideways})",
        0.05,
        0.3,
        "course",
    ),
    _cost(
        "off_course",
        "stay on the course",
        "Distance from the straight course, in m, up to a limit.",
        "off_course = {w} * np.minimum(np.abs({offset}), 3.0)",
        0.03,
        0.15,
        "course",
    ),
)

TERMS: dict[str, Term] = {
    term.name: term for term in (*FORWARD, *UPWARD, *_SURVIVAL, *_BONUSES, *_COSTS)
}
"""All terms by name. Those for the task itself come first."""
