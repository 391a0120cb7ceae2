"""Reward terms that are the task itself; one of them leads every reward."""

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
        "get going, with diminishing returns",
        "The first metre per second is worth the most, so that learning starts early.",
        "{w} * np.sign(x_velocity) * np.log1p(np.abs(x_velocity))",
        4.0,
        8.0,
    ),
    _forward(
        "sprint",
        "sprint, with increasing returns",
        "Speed pays more than in proportion: a slow shuffle is not good enough.",
        "{w} * x_velocity * (1.0 + 0.1 * np.abs(x_velocity))",
        2.0,
        4.0,
    ),
    _forward(
        "steady_pace",
        "keep a steady pace, then go faster",
        "Most of the value lies in moving at about 2 m/s at all; more speed still pays.",
        "{w} * (np.tanh(0.5 * x_velocity) + 0.2 * x_velocity)",
        4.0,
        8.0,
    ),
    _forward(
        "upright_progress",
        "progress that counts while upright",
        "Speed counts in proportion to how upright the torso is: no tumbling forward.",
        "{w} * x_velocity * np.clip({up}, 0.2, 1.0)",
        2.0,
        5.0,
    ),
    _forward(
        "aligned_progress",
        "progress that counts while facing ahead",
        "Speed counts in full only when the body points along the course.",
        "{w} * x_velocity * (0.6 + 0.4 * ({heading}))",
        2.0,
        5.0,
    ),
)

UPWARD = (
    _upward(
        "height_gain",
        "be high",
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
        "push off hard",
        "Only the way up counts, and a fast push-off counts more than in proportion.",
        "launch = {w} * np.square(np.clip({lift}, 0.0, 10.0))",
        1.0,
        3.0,
    ),
    _upward(
        "high_leap",
        "leap high rather than often",
        "Twice the height is worth four times as much: one high leap beats many small hops.",
        "leap = np.clip({height} - {rest}, 0.0, 5.0)\nhigh_leap = {w} * (leap + np.square(leap))",
        4.0,
        12.0,
    ),
    _upward(
        "new_record",
        "beat the best height of the episode",
        "Paid when the torso gets higher than ever before in this episode, and while it is high.",
        'if not hasattr(self, "_record"):\n'
        "    self._record = {rest}\n"
        "new_record = {w} * (10.0 * max({height} - self._record, 0.0) + {height} - {rest})\n"
        "self._record = max(self._record, {height})",
        2.0,
        6.0,
    ),
)
