"""Finds the Python code in the answer of a language model.

It accepts fences, prose, JSON and thoughts around the code, and code in several blocks, as long as
the answer has only one possible meaning.
"""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator, Sequence
from typing import Any

from robomore.designers.llm.extraction import NotFound, Unreadable, cleared
from robomore.designers.llm.fences import Block, blocks_of, blocks_within, dedented
from robomore.designers.llm.thoughts import after_final_heading
from robomore.designers.llm.wrappings import straightened, without_entities

_MOST_BLOCKS = 20
"""Blocks of code that are looked at. An answer has a few, hostile text has thousands."""

_LEFT_OUT = re.compile(
    r"#[ \t]*(?:\.{3}|…)(?=.{0,60}\b(?:rest|remain\w*|same|before|unchanged|previous|existing)\b)"
    r"(?:[^\w\n]*\b(?:the|all|and|keep|other|everything|else|rest|remain\w*|same|as|is|are|stays?|of|"
    r"your|here|before|above|unchanged|previous|existing|code|lines?|parts?|terms?|rewards?|function|"
    r"computations?|calculations?|logic|implementation|omitted)\b)+[^\w\n]*$",
    re.IGNORECASE | re.MULTILINE,
)
"""A comment that says no more than that the rest stays. Others may begin with dots, too."""
_TAG = re.compile(r"</?(?:code|python|reward|function|reward_function|reward_code)>")
_CODE_LINE = re.compile(
    r"(?:async\s+def|def|class)\s+\w+|(?:import|from)\s+[\w.]+|@\w|#|[A-Za-z_]\w*\s*(?::[^=]+)?=[^=]|"
    r'["\']{3}|[)\]}]|if\s+__name__|try:|except\b.*:'
)


def find_code(text: str, wanted: str) -> tuple[str, bool]:
    """Return the Python code in `text` that defines the function `wanted`, or any other function,
    and whether its end was marked.

    Raises:
        NotFound: there is no code, or a part of it, or there are several versions of it.
    """
    code, closed = _of_characters(text, wanted) or _found(text, wanted)
    if left_out := _LEFT_OUT.search(code):
        raise NotFound(f"the answer leaves out code (`{left_out[0]}`); answer with all of it")
    straight = straightened(code)
    if straight != code and parsed(code) is None and parsed(straight) is not None:
        code = straight
    return code, closed


def _of_characters(text: str, wanted: str) -> Block | None:
    """Return the code in a text that writes `<` as `&lt;`, if it is one.

    Such code can be valid Python by chance: `a &lt; b` is two statements.
    """
    plain = without_entities(text)
    if plain == text:
        return None
    try:
        block = _found(plain, wanted)
    except NotFound:
        return None
    return block if parsed(block[0]) is not None else None


def _found(text: str, wanted: str) -> tuple[str, bool]:
    text = _quoted(cleared(text, wanted), wanted)
    blocks = [inner for block in blocks_of(text) for inner in blocks_within(block)]
    blocks = [inner for block in blocks for inner in _from_json(block, wanted)]
    if not blocks and "{" in text:
        whole = text[text.index("{") : text.rfind("}") + 1], True
        blocks = [block for block in _from_json(whole, wanted) if block != whole]
    defining = _defining(blocks, wanted)
    if len(defining) > 1:
        final = after_final_heading(text)
        blocks_after = [inner for block in blocks_of(final or "") for inner in blocks_within(block)]
        last = _defining(blocks_after, wanted)
        if len(last) != 1:
            raise NotFound(
                f"the answer holds {len(defining)} code blocks that define `{wanted}`; answer "
                "with one"
            )
        defining = last
    if defining:
        code, closed = defining[0]
        return _with_needed(code, [other for other, _ in blocks if other != code]), closed
    code_blocks = (block for block in blocks if re.search(r"\bdef\s+\w+", block[0]))
    return next(code_blocks, None) or (_bare(text, wanted), False)


def _defining(blocks: Sequence[Block], wanted: str) -> list[Block]:
    """Return the different blocks that define `wanted`; outlines do not count beside them."""
    definition = re.compile(rf"\bdef\s+{re.escape(wanted)}\b")
    found: dict[str, bool] = {}
    for code, closed in blocks:
        if definition.search(code):
            found.setdefault(code, closed)
    written = {code: closed for code, closed in found.items() if not _is_outline(code, wanted)}
    return list((written or found).items())


def _is_outline(code: str, wanted: str) -> bool:
    """Return whether `wanted` has nothing but words and dots in a block of code."""
    tree = parsed(code)
    bodies = [
        node.body
        for node in (tree.body if tree else ())
        if isinstance(node, ast.FunctionDef) and node.name == wanted
    ]
    return bool(bodies) and all(
        isinstance(one, ast.Pass)
        or (isinstance(one, ast.Expr) and isinstance(one.value, ast.Constant))
        for body in bodies
        for one in body
    )


def _with_needed(code: str, others: Sequence[str]) -> str:
    """Return `code` with those of the other blocks before it that define names which it needs.

    Raises:
        NotFound: two blocks define the same name in different ways.
    """
    providers: dict[str, list[str]] = {}
    for block in dict.fromkeys(others[:_MOST_BLOCKS]):
        for name in _definitions(block):
            providers.setdefault(name, []).append(block)
    added: list[str] = []
    while True:
        missing = _missing_names("\n".join([*added, code]))
        needed = [name for name in sorted(missing) if name in providers]
        if not needed:
            break
        blocks = providers.pop(needed[0])
        if len(blocks) > 1:
            raise NotFound(
                f"the answer holds {len(blocks)} code blocks that define `{needed[0]}`; answer "
                "with one"
            )
        added.append(blocks[0])
    in_order = [block for block in others if block in added]
    return "\n\n\n".join([*dict.fromkeys(in_order), code])


def _definitions(code: str) -> set[str]:
    """Return the names that a block of definitions, imports and constants defines.

    A block that does anything else, such as a call, is an example of use. It defines nothing.
    """
    tree = parsed(code)
    names: set[str] = set()
    for node in tree.body if tree else ():
        match node:
            case ast.FunctionDef() | ast.ClassDef():
                names.add(node.name)
            case ast.Import() | ast.ImportFrom():
                names |= {(alias.asname or alias.name).split(".")[0] for alias in node.names}
            case ast.Assign() | ast.AnnAssign():
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names |= {name for target in targets for name in _stored(target)}
            case ast.Expr(value=ast.Constant()):
                pass
            case _:
                return set()
    return names


def _missing_names(code: str) -> set[str]:
    """Return the names that `code` reads and binds nowhere."""
    tree = parsed(code)
    read: set[str] = set()
    bound: set[str] = set()
    for node in ast.walk(tree) if tree else ():
        match node:
            case ast.Name(ctx=ast.Load()):
                read.add(node.id)
            case ast.Name():
                bound.add(node.id)
            case ast.arg():
                bound.add(node.arg)
            case ast.FunctionDef() | ast.ClassDef():
                bound.add(node.name)
            case ast.alias():
                bound.add((node.asname or node.name).split(".")[0])
    return read - bound


def _stored(target: ast.expr) -> Iterator[str]:
    for node in ast.walk(target):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def parsed(code: str) -> ast.Module | None:
    """Return the syntax tree of `code`; `None` if it is no Python."""
    try:
        return ast.parse(code)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def _quoted(text: str, wanted: str) -> str:
    """Return code that is the value of a JSON object or a Python string, or else `text`."""
    if text[0] in "{[":
        return _value(text, wanted) or text
    if text[0] in "'\"" and text[-1] == text[0]:
        try:
            found = ast.literal_eval(text)
        except (ValueError, SyntaxError, RecursionError, MemoryError):
            # A quote around fenced code of several lines.
            return text[1:-1] or text
        return found.strip() if isinstance(found, str) and found.strip() else text
    return text


def _from_json(block: Block, wanted: str) -> list[Block]:
    """Return the blocks of code in a block of JSON, or else the block itself."""
    code, closed = block
    value = _value(code.strip(), wanted) if code.lstrip()[:1] in ("{", "[") else None
    return [block] if value is None else blocks_of(value) or [(value, closed)]


def _value(text: str, wanted: str) -> str | None:
    """Return the text in JSON that defines `wanted`."""
    definition = re.compile(rf"\bdef\s+{re.escape(wanted)}\b")
    values = (value for value in _strings(_plain_data(text)) if definition.search(value))
    return next((value.strip("\n") for value in values), None)


def _plain_data(text: str) -> Any:
    """Return JSON or a Python literal as data, `None` if it is neither."""
    try:
        return json.loads(text, strict=False)
    except (ValueError, RecursionError):
        pass
    try:
        return ast.literal_eval(text)
    except (ValueError, SyntaxError, RecursionError, MemoryError, TypeError):
        return None


def _strings(data: Any, depth: int = 0) -> Iterator[str]:
    """Yield the texts in `data`. A list of texts counts as the lines of one text."""
    if isinstance(data, str):
        yield data
        if depth < 4 and data.lstrip().startswith("{"):
            yield from _strings(_plain_data(data.strip()), depth + 1)
    elif isinstance(data, list) and data and all(isinstance(item, str) for item in data):
        yield "\n".join(line.rstrip("\n") for line in data)
    elif isinstance(data, dict | list) and depth < 4:
        for item in data.values() if isinstance(data, dict) else data:
            yield from _strings(item, depth + 1)


def _bare(text: str, wanted: str) -> str:
    """Return code without fences from the prose around it."""
    lines = _TAG.sub("\n", text).split("\n")
    first = re.compile(r"\s*(?:(?:async\s+)?def|class)\s+\w+\s*[(:]")
    start = next((index for index, line in enumerate(lines) if first.match(line)), None)
    if start is None:
        raise Unreadable(f"the answer holds no Python code that defines `{wanted}`")
    margin = len(lines[start]) - len(lines[start].lstrip())
    while start > 0 and _is_code(lines[start - 1], margin) and lines[start - 1].strip():
        start -= 1
    whole = dedented(lines[start:])
    if parsed(whole) is not None:
        return whole
    end = start
    while end < len(lines) and _is_code(lines[end], margin):
        end += 1
    return dedented(lines[start:end])


def _is_code(line: str, margin: int) -> bool:
    indent = len(line) - len(line.lstrip())
    return not line.strip() or indent > margin or bool(_CODE_LINE.match(line.strip()))
