"""One way to find what can be named: tasks, methods, designers, trainers and executors.

Each kind has one `Registry`. It knows the items of this package, and those of other installed
packages through an entry-point group. Nothing is imported before it is asked for, and a plug-in
that does not load is one warning: everything else still works.
"""

from __future__ import annotations

import importlib
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from importlib.metadata import EntryPoint, distributions, entry_points
from typing import Generic, TypeVar

from robomore.errors import InputError
from robomore.suggestions import no_such

T = TypeVar("T")

log = logging.getLogger(__name__)


class Registry(Generic[T]):
    """Items of one kind by name.

    Args:
        kind: what an item is called in messages, such as `task` or `method`.
        group: entry-point group in which other packages name theirs.
        built_in: this package's items by name, or `module:attribute` where one is found.
        fault: returns what is wrong with a loaded object of that name, or an empty text.
    """

    def __init__(
        self,
        kind: str,
        group: str,
        built_in: Mapping[str, T | str],
        fault: Callable[[str, object], str],
    ) -> None:
        self.kind = kind
        self.group = group
        self._items: dict[str, T | str] = dict(built_in)
        self._fault = fault
        self._warned: set[str] = set()

    def register(self, name: str, item: T) -> None:
        """Add an item for this process.

        A worker process does not see it: an installed package with an entry point is for that.

        Raises:
            InputError: the name is taken, or the item is not of this kind.
        """
        if name in self._items or name in self._plugins:
            raise InputError(f"two {self.kind}s are called {name!r}; rename one of them")
        if said := self._fault(name, item):
            raise InputError(f"the {self.kind} {name!r} {said}")
        self._items[name] = item

    def get(self, name: str) -> T:
        """Return the item of that name.

        Raises:
            InputError: there is none, or the package that has it does not load.
        """
        if name in self._items:
            return self._own(name)
        if name in self._plugins:
            return self._plugin(name)
        raise no_such(self.kind, name, self.names())

    def names(self) -> tuple[str, ...]:
        """Return all names, this package's first; nothing is loaded."""
        return (*self._items, *self._plugins)

    def __contains__(self, name: object) -> bool:
        return name in self._items or name in self._plugins

    def __len__(self) -> int:
        return len(self.names())

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __getitem__(self, name: str) -> T:
        return self.get(name)

    def items(self) -> Iterator[tuple[str, T]]:
        """Yield every item that loads with its name; what does not is one warning each."""
        for name in self._items:
            yield name, self._own(name)
        for name in self._plugins:
            try:
                yield name, self._plugin(name)
            except InputError as error:
                if name not in self._warned:
                    self._warned.add(name)
                    log.warning("%s; everything else still works", error)

    @cached_property
    def _plugins(self) -> dict[str, EntryPoint]:
        found: dict[str, EntryPoint] = {}
        for entry in plugin_entries(self.group):
            if entry.name in self._items or entry.name in found:
                log.warning(
                    "the %s %s is left out: its name is taken; rename it", self.kind, _origin(entry)
                )
                continue
            found[entry.name] = entry
        return found

    def _own(self, name: str) -> T:
        item = self._items[name]
        if not isinstance(item, str):
            return item
        module, _, attribute = item.partition(":")
        loaded: T = getattr(importlib.import_module(module), attribute)
        self._items[name] = loaded
        return loaded

    def _plugin(self, name: str) -> T:
        entry = self._plugins[name]
        try:
            loaded: T = entry.load()
        except (Exception, SystemExit) as error:
            raise InputError(
                f"the {self.kind} {_origin(entry)} does not load: {type(error).__name__}: {error}; "
                "mend that package, or remove it"
            ) from error
        if said := self._fault(name, loaded):
            raise InputError(f"the {self.kind} {_origin(entry)} {said}; mend that package")
        return loaded


def plugin_entries(group: str) -> Iterable[EntryPoint]:
    """Return what installed packages announce in an entry-point group.

    A package whose announcement cannot be read is one warning, and all others are found.
    """
    try:
        return entry_points(group=group)
    except Exception:  # noqa: BLE001  # it stands in somebody else's file
        found: dict[str, EntryPoint] = {}
        for package in distributions():
            try:
                for entry in package.entry_points.select(group=group):
                    found.setdefault(entry.name, entry)
            except Exception as error:  # noqa: BLE001
                name = package.metadata["Name"]
                log.warning("the entry points of the package %s cannot be read: %s", name, error)
        return found.values()


def _origin(entry: EntryPoint) -> str:
    package = f" of the package {entry.dist.name}" if entry.dist else ""
    return f"{entry.name} = {entry.value}{package}"
