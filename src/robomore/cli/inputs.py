"""What users hand over in files: parameters as JSON, rewards as Python text."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from robomore.errors import InputError, InvalidMorphology, InvalidReward
from robomore.plain_files import cannot_write
from robomore.rewards.check import why_unparsed
from robomore.search.named_starts import NAMED_STARTS, named_start
from robomore.suggestions import path_meant
from robomore.tasks import Task
from robomore.types import Morphology, Reward, Start

REFERENCE = "reference"

_MOST_BYTES = 2**24
"""Bytes of a text that is read."""


def read_parameters(task: Task, given: str) -> tuple[float, ...]:
    """Return checked parameters in the task's order.

    Args:
        task: that they are for.
        given: `reference`, or the name of a JSON file: a list in the task's order, an object
            by name, or a champion's `design.json`.

    Raises:
        InputError: the file cannot be read or used.
        InvalidMorphology: the task refuses the parameters; the message names the file.
    """
    if given == REFERENCE:
        return task.reference
    text = read_text(Path(given), f"name a JSON file, or `{REFERENCE}` for the reference robot")
    try:
        found = json.loads(text, object_pairs_hook=_each_name_once)
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"{given} is not JSON ({error}); write a list in the task's order or an object by name"
        ) from None
    if isinstance(found, dict) and isinstance(found.get("parameters"), dict | list):
        found = found["parameters"]
    if not isinstance(found, dict | list):
        raise InputError(
            f"{given} holds a {type(found).__name__}; write a list of {len(task.parameters)} "
            f"numbers or an object with {', '.join(task.names)}"
        )
    values = found if isinstance(found, dict) else dict(enumerate(found, start=1))
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{given}: {name} is {json.dumps(value)}, which is not a number")
    try:
        return task.check(found)
    except InvalidMorphology as error:
        raise InvalidMorphology(f"{given}: {error}") from None


def read_reward(task: Task, given: str) -> str:
    """Return the text of a reward that parses; whatever else is wrong with it, training will say.

    Args:
        task: whose reference reward is meant by `reference`.
        given: `reference`, or the name of a Python file.

    Raises:
        InputError: the file cannot be read.
        InvalidReward: it does not parse.
    """
    if given == REFERENCE:
        return task.reward
    source = read_text(
        Path(given), f"name a Python file, or `{REFERENCE}` for the reference reward"
    )
    try:
        ast.parse(source)
    except SyntaxError as error:
        raise InvalidReward(
            f"{given}, line {error.lineno}: does not parse: {why_unparsed(source, error)}; correct "
            "the file"
        ) from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise InvalidReward(f"{given} does not parse: {error}; correct the file") from None
    return source


def read_start(task: Task, given: str) -> Start:
    """Return what a search is to start from.

    Args:
        task: of the search.
        given: a JSON file with parameters, a Python file with a reward, the folder of a run (its
            champion is meant), the folder of one design, or one of `NAMED_STARTS`.

    Raises:
        InputError: there is nothing of that kind.
        InvalidMorphology, InvalidReward: as `read_parameters` and `read_reward`.
    """
    if given in NAMED_STARTS:
        return named_start(task, given)
    path = Path(given)
    if (path / "run.json").is_file():
        from robomore.experiment.starting import champion_of
        from robomore.runs import load_run

        return champion_of(task, load_run(path))
    design, reward = path / "design.json", path / "reward.py"
    if path.is_dir() and design.is_file():
        source = Reward(read_reward(task, str(reward))) if reward.is_file() else None
        return Start(given, Morphology(read_parameters(task, str(design))), source)
    if path.suffix == ".py":
        return Start(given, reward=Reward(read_reward(task, given)))
    if path.suffix == ".json":
        return Start(given, Morphology(read_parameters(task, given)))
    raise InputError(
        f"--start-from {given} is nothing to start from.{path_meant(path)} Name a .json file with "
        "parameters, a .py file with a reward, the folder of a run, a folder with design.json and "
        f"reward.py, or write {' or '.join(NAMED_STARTS)}"
    )


def read_options(option: str, given: Sequence[str] | None, example: str) -> dict[str, Any]:
    """Return `name=value` pairs by name: values are JSON, and text where they are not.

    Args:
        option: name of the command's option.
        given: what it was given, each time.
        example: a pair that it takes.

    Raises:
        InputError: one of them is no such pair.
    """
    options: dict[str, Any] = {}
    for pair in given or ():
        name, equals, value = pair.partition("=")
        if not (name and equals):
            raise InputError(f"--{option} {pair!r} is no NAME=VALUE; write {example}, for example")
        try:
            options[name] = json.loads(value)
        except ValueError:
            options[name] = value
    return options


def read_duration(option: str, given: str) -> float:
    """Return a time such as `90s`, `30m` or `2h` in seconds.

    Raises:
        InputError: it is none, has no unit, or is not above 0.
    """
    found = re.fullmatch(r"(\d+(?:\.\d+)?)\s*(s|m|h)?", given.strip())
    if not found or not float(found[1]):
        raise InputError(f"--{option} {given} is no time; write 90s, 30m or 2h")
    number, unit = found.groups()
    if unit is None:
        raise InputError(f"--{option} {given} has no unit; write {number}s, {number}m or {number}h")
    return float(number) * {"s": 1, "m": 60, "h": 3600}[unit]


def read_bytes(option: str, given: str) -> int:
    """Return an amount of memory such as `512MiB` or `2GiB` in bytes.

    Raises:
        InputError: it is none, or not above 0.
    """
    found = re.fullmatch(r"(\d+(?:\.\d+)?)\s*([KMGT])(?:i?B)?", given.strip())
    amount = int(float(found[1]) * 2 ** (10 * (1 + "KMGT".index(found[2])))) if found else 0
    if not amount:
        raise InputError(f"--{option} {given} is no amount of memory; write 512MiB or 2GiB")
    return amount


def read_text(path: Path, remedy: str) -> str:
    """Return the text of a file, without the byte order mark that some editors put before it.

    Raises:
        InputError: there is none, it is not text, or it is very long.
    """
    try:
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise InputError(f"{path} has more than {_MOST_BYTES:,} bytes; {remedy}")
        return content.decode("utf-8-sig")
    except OSError as error:
        why = f"{error.strerror}.{path_meant(path)}".rstrip(".")
        raise InputError(f"{path} cannot be read ({why}); {remedy}") from None
    except UnicodeDecodeError:
        raise InputError(f"{path} is no text in UTF-8; save it as such, or {remedy}") from None


def positive(**numbers: int | None) -> None:
    """Refuse numbers below 1; `None` stands for an option that was not given.

    Raises:
        InputError: naming the option.
    """
    for name, value in numbers.items():
        if value is not None and value < 1:
            raise InputError(f"--{name.replace('_', '-')} is {value}; give a number from 1 up")


def seed_number(seed: int) -> None:
    """Refuse a seed below 0.

    Raises:
        InputError: it is below 0.
    """
    if seed < 0:
        raise InputError(f"--seed is {seed}; give a whole number from 0 up")


def new_folder(path: Path) -> None:
    """Make a folder, or accept an empty one: nothing of the user's is ever overwritten.

    Raises:
        InputError: it holds something, or cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        if any(path.iterdir()):
            raise InputError(f"{path} is not empty; name a new folder with --out")
    except OSError as error:
        raise cannot_write(path, error, "name another folder with --out") from None


def _each_name_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    names = [name for name, _ in pairs]
    if twice := [name for name in dict.fromkeys(names) if names.count(name) > 1]:
        raise ValueError(f"{twice[0]!r} stands there more than once")
    return dict(pairs)
