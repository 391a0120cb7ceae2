"""Attributes that a reward looks for and that are not there: named, with what was probably meant.

`getattr` with a default, `hasattr` and `except AttributeError` hide such a mistake from its author.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from difflib import get_close_matches

_MOST = 64
_LONGEST = 80

_NOT_MEANT = frozenset(
    (
        *("camera_id", "camera_name", "height", "metadata", "mujoco_renderer", "render"),
        *("render_mode", "width"),
        *("close", "do_simulation", "fullpath", "get_wrapper_attr", "has_wrapper_attr", "reset"),
        *("reset_model", "set_state", "set_wrapper_attr", "spec", "step", "unwrapped"),
        *("control_map", "judges_health", "np_random_seed", "observation_structure"),
        *("observed_views", "observes_forces", "position_view"),
    )
)
"""What every robot's class has for pictures, for running the simulation and for many at once."""
_MACHINERY = frozenset(("_ezpickle_args", "_parameters", "_reward_calls", "_simulation_index"))
"""What is private, and a number or a tuple all the same."""


def names_for_rewards(robot: object) -> list[str]:
    """Return the attributes of a robot's environment that a reward may have meant.

    Those are facts about the robot; what draws it or runs the simulation is left out.

    Args:
        robot: `self` of a reward.
    """
    numbers = (bool, int, float, tuple)
    return [
        name
        for name in dir(robot)
        if name not in _NOT_MEANT
        and name not in _MACHINERY
        and not name.startswith(("__", "batch_"))
        # Of what is private, settings such as `_healthy_z_range` alone.
        and (name[0] != "_" or type(vars(robot).get(name)) in numbers)
    ]


class MissingAttributes:
    """What was looked for in vain.

    Attributes:
        found: by the path as a reward writes it, what was probably meant; empty if nothing is near.
    """

    def __init__(self) -> None:
        self.found: dict[str, str] = {}

    def error(
        self, holder: str, name: str, kind: str, known: Callable[[], Iterable[str]]
    ) -> AttributeError:
        """Note that there is no such attribute, and return the error that says so.

        Args:
            holder: where it was looked for: `self`, `self.data` or `self.model`.
            name: of the attribute.
            kind: type of the object.
            known: returns the attributes that are there; asked once for each name.
        """
        path = f"{holder}.{name}"[:_LONGEST]
        if path not in self.found:
            public = [one for one in known() if not one.startswith("__")]
            near = get_close_matches(name[:_LONGEST], public, 1)
            if len(self.found) < _MOST:
                self.found[path] = near[0] if near else ""
        else:
            near = [self.found[path]] if self.found[path] else []
        hint = f"; did you mean `{near[0]}`?" if near else ""
        return AttributeError(f"'{kind}' object has no attribute {name!r}{hint}", name=name)
