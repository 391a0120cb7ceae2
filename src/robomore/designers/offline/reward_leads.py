"""Reward terms for the task itself. Every reward has one of them as its leading term."""

from __future__ import annotations

from robomore.designers.offline.reward_term import Term


def _forward(name: str, idea: str, comment: str, code: str, low: float, high: float) -> Term:
    return Term(name, "task", idea, comment, f"{name} = {code}", low, high, "task", (), "distance")


def _upward(name: str, idea: str, comment: str, code: str, low: float, high: float) -> Term:
    return Term(name, "task", idea, comment, code, low, high, "task", (), "height")


FORWARD = (
    _forward(
        "forward_speed",
        "run fast",
        "Forward speed, in m/s, is what the task is about.",
        "{w} * x_velocity",
        2.0,
        5.0,
    ),
    _forward(
        "early_progress",
        "start to move, with diminishing returns",
        "The first metre per second is worth the most, so that learning starts early.",
        "{w} * np.sign(x_velocity) * np.log1p(np.abs(x_velocity))",
        4.0,
        8.0,
    ),
    _forward(
        "sprint",
        "run fast, with increasing returns",
        "The reward grows faster than the speed, so slow motion is not enough.",
        "{w} * x_velocity * (1.0 + 0.1 * np.abs(x_velocity))",
        2.0,
        4.0,
    ),
    _forward(
        "steady_pace",
        "reach a steady speed, then run faster",
        "Most of the reward is for about 2 m/s; more speed still adds some.",
        "{w} * (np.tanh(0.5 * x_velocity) + 0.2 * x_velocity)",
        4.0,
        8.0,
    ),
    _forward(
        "upright_progress",
        "speed while upright",
        "Speed counts in proportion to how upright the torso is.",
        "{w} * x_velocity * np.clip({up}, 0.2, 1.0)",
        2.0,
        5.0,
    ),
    _forward(
        "aligned_progress",
        "speed while facing ahead",
        "Speed counts in full only when the torso points along the course.",
        "{w} * x_velocity * (0.6 + 0.4 * ({heading}))",
        2.0,
        5.0,
    ),
)

UPWARD = (
    _upward(
        "height_gain",
        "gain height",
        "Height of the torso above its starting height, in m.",
        "height_gain = {w} * ({height} - {rest})",
        4.0,
        12.0,
    ),
    _upward(
        "upward_speed",
        "move upward",
        "Vertical speed of the torso, in m/s.",
        "upward_speed = {w} * {lift}",
        2.0,
        6.0,
    ),
    _upward(
        "launch",
        "push off fast",
        "Only upward speed counts, and it counts with its square.",
        "launch = {w} * np.square(np.clip({lift}, 0.0, 10.0))",
        1.0,
        3.0,
    ),
    _upward(
        "high_leap",
        "jump high rather than often",
        "The reward grows faster than the height: one high jump beats many small ones.",
        "leap = np.clip({height} - {rest}, 0.0, 5.0)\nhigh_leap = {w} * (leap + np.square(leap))",
        4.0,
        12.0,
    ),
    _upward(
        "new_record",
        "exceed the greatest height of the episode",
        "A reward for a new greatest height of the torso in this episode, and for height.",
        'if not hasattr(self, "_record"):\n'
        "    self._record = {rest}\n"
        "new_record = {w} * (10.0 * max({height} - self._record, 0.0) + {height} - {rest})\n"
        "self._record = max(self._record, {height})",
        2.0,
        6.0,
    ),
)
