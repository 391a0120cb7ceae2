"""No module of RoboMoRe imports itself, at first or second hand, as it is loaded."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src"

Graph = dict[str, set[str]]


def import_graph(source: Path, package: str) -> Graph:
    """Return, for each module of a package, the modules of it that it imports when it is loaded."""
    files = {name_of(file, source): file for file in sorted((source / package).rglob("*.py"))}
    graph: Graph = {}
    for name, file in files.items():
        inside = name if file.name == "__init__.py" else name.rpartition(".")[0]
        found = {one for one in imported(ast.parse(file.read_text()).body, inside) if one in files}
        graph[name] = found - {name}
    return graph


def name_of(file: Path, source: Path) -> str:
    return ".".join(file.relative_to(source).with_suffix("").parts).removesuffix(".__init__")


def imported(statements: list[ast.stmt], package: str) -> Iterator[str]:
    """Yield what top-level statements import: of `from a import b`, both `a` and `a.b`."""
    for node in statements:
        match node:
            case ast.Import(names=names):
                yield from (alias.name for alias in names)
            case ast.ImportFrom(module=module, names=names, level=level):
                above = package.rsplit(".", level - 1)[0] if level > 1 else package
                base = ".".join(filter(None, (above if level else "", module)))
                members = [f"{base}.{alias.name}" for alias in names]
                # A package that is asked for its modules alone may be loading itself.
                yield from ([base, *members] if base != package else members)
            case ast.If(test=test, body=body, orelse=other):
                if "TYPE_CHECKING" not in ast.unparse(test):
                    yield from imported(body, package)
                yield from imported(other, package)
            case ast.Try(body=body, handlers=handlers, orelse=other):
                yield from imported([*body, *other], package)
                for handler in handlers:
                    yield from imported(handler.body, package)


def circle_in(graph: Graph) -> list[str]:
    """Return the modules of one circle in the order of their imports, or an empty list."""
    done: set[str] = set()

    def search(name: str, path: list[str]) -> list[str]:
        if name in path:
            return [*path[path.index(name) :], name]
        if name in done:
            return []
        for other in sorted(graph[name]):
            if circle := search(other, [*path, name]):
                return circle
        done.add(name)
        return []

    for name in graph:
        if circle := search(name, []):
            return circle
    return []


def test_no_import_circles() -> None:
    circle = circle_in(import_graph(SOURCE, "robomore"))
    assert not circle, f"an import circle: {' imports '.join(circle)}"


def test_a_circle_is_found_and_named(tmp_path: Path) -> None:
    package = tmp_path / "ring"
    (package / "inner").mkdir(parents=True)
    for name, text in {
        "__init__": "",
        "a": "from ring.inner import b",
        "c": "try:\n    from . import a\nexcept ImportError:\n    pass",
        "inner/__init__": "",
        "inner/b": "if 1:\n    from ..c import A\n",
        "d": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import ring.e",
        "e": "import ring.d\ndef late():\n    import ring.a",
    }.items():
        (package / f"{name}.py").write_text(text)
    graph = import_graph(tmp_path, "ring")
    assert circle_in(graph) == ["ring.a", "ring.inner.b", "ring.c", "ring.a"]
    assert graph["ring.d"] == set() and graph["ring.e"] == {"ring.d"}
