"""Rewards that keep something between calls, one for each place where that can hide."""

from __future__ import annotations

import textwrap


def reward(setup: str, body: str, parameters: str = "") -> str:
    """Return a reward; `body` computes `k` from the speed `v` and from what is kept."""
    lines = textwrap.indent(textwrap.dedent(body).strip(), "    ")
    return (
        f"{textwrap.dedent(setup).strip()}\n\n"
        f"def _get_rew(self, x_velocity, action{parameters}):\n"
        f"    v = float(x_velocity)\n{lines}\n"
        "    return v + k, {'v': v, 'k': k}\n"
    )


EMA = """
class Ema:
    rate = 0.9
    def __init__(self, start=0.0):
        self.value = start
    def update(self, v):
        self.value = self.rate * self.value + (1 - self.rate) * v
        return self.value
"""

KEPT = {
    "attribute of self": reward("", "self.k = getattr(self, 'k', 0.0) * 0.9 + v\nk = self.k"),
    "list at the top level": reward("H = []", "H.append(v)\nk = sum(H) / len(H)"),
    "dict at the top level": reward("M = {'last': 0.0}", "k = v - M['last']\nM['last'] = v"),
    "global": reward("COUNT = 0", "global COUNT\nCOUNT += 1\nk = 1 / COUNT"),
    "global made in a call": reward(
        "", "global LAST\nk = LAST if self.training_steps > 2 else v\nLAST = v"
    ),
    "default argument": reward("", "k = v - m['x']\nm['x'] = v", ", m={'x': 0.0}"),
    "keyword default": reward("", "m.append(v)\nk = m[len(m) // 2]", ", *, m=[]"),
    "default of a helper": reward(
        "def f(v, m=[]):\n    m.append(v)\n    return sum(m)", "k = f(v)"
    ),
    "attribute of the function": reward(
        "", "k = getattr(_get_rew, 'last', 0.0)\n_get_rew.last = v"
    ),
    "nonlocal": reward(
        """
        def make():
            n = 0
            def count():
                nonlocal n
                n += 1
                return n
            return count
        count = make()
        """,
        "k = 1.0 / count()",
    ),
    "list in a closure": reward(
        "def make():\n    m = []\n    def f(v):\n        m.append(v)\n        return sum(m[-3:])\n"
        "    return f\nf = make()",
        "k = f(v)",
    ),
    "closure made in a call": reward(
        "def make():\n    m = []\n    def f(v):\n        m.append(v)\n        return sum(m[-3:])\n"
        "    return f",
        "if not hasattr(self, 'f'): self.f = make()\nk = self.f(v)",
    ),
    "two closures over one cell": reward(
        "def make():\n    n = 0.0\n    def put(v):\n        nonlocal n\n        n = n * 0.5 + v\n"
        "    def get():\n        return n\n    return put, get",
        "if not hasattr(self, 'f'): self.f = make()\nself.f[0](v)\nk = self.f[1]()",
    ),
    "lambda in a list": reward("F = [lambda v, m=[]: m.append(v) or len(m)]", "k = F[0](v)"),
    "decorator": reward(
        "import functools\ndef smooth(f):\n    seen = []\n    @functools.wraps(f)\n"
        "    def g(v):\n        seen.append(f(v))\n        return sum(seen[-4:])\n    return g\n"
        "@smooth\ndef speed(v):\n    return 2 * v",
        "k = speed(v)",
    ),
    "default of a function in a type": reward(
        "from typing import Annotated, get_args\n"
        "A = Annotated[float, lambda v, m=[]: m.append(v) or sum(m)]",
        "k = get_args(A)[1](v)",
    ),
    "class that only a type knows": reward(
        "from typing import get_args\nclass C:\n    n = 0.0\nA = list[C]\ndel C",
        "c = get_args(A)[0]\nc.n += v\nk = c.n",
    ),
    "class attribute": reward("class S:\n    n = 0", "S.n += 1\nk = 1 / S.n"),
    "list in a class": reward("class S:\n    h = []", "S.h.append(v)\nk = sum(S.h[-2:])"),
    "new class attribute": reward("class S:\n    pass", "k = getattr(S, 'last', 0.0)\nS.last = v"),
    "inherited class attribute": reward(
        "class A:\n    h = []\nclass B(A):\n    pass", "B.h.append(v)\nk = sum(A.h)"
    ),
    "default of a method": reward(
        "class S:\n    def f(self, v, m=[]):\n        m.append(v)\n        return sum(m)\n"
        "    @staticmethod\n    def g(v, m=[]):\n        m.append(v)\n        return len(m)\n"
        "    @classmethod\n    def h(cls, v, m={}):\n        m[len(m)] = v\n        return len(m)\n"
        "    @property\n    def p(self, m=[0]):\n        m[0] += 1\n        return m[0]",
        "s = S()\nk = s.f(v) + S.g(v) + S.h(v) + s.p",
    ),
    "helper object at the top level": reward(EMA + "e = Ema()", "k = e.update(v)"),
    "helper object in self": reward(
        EMA, "if not hasattr(self, 'e'): self.e = Ema(v)\nk = self.e.update(v)"
    ),
    "helper object in a closure": reward(
        EMA + "def make():\n    e = Ema()\n    return lambda v: e.update(v)\nf = make()", "k = f(v)"
    ),
    "bound method": reward(EMA + "update = Ema().update", "k = update(v)"),
    "bound method of a list": reward("H = []\npush = H.append", "push(v)\nk = sum(H)"),
    "slots": reward(
        "class S:\n    __slots__ = ('a', 'b')\n    def __init__(self):\n        self.a = 0.0",
        "if not hasattr(self, 's'): self.s = S()\nself.s.a += v\nk = self.s.a",
    ),
    "dataclass": reward(
        "from dataclasses import dataclass, field\n@dataclass\nclass S:\n    last: float = 0.0\n"
        "    h: list = field(default_factory=list)\nS0 = S()",
        "S0.h.append(v)\nk = v - S0.last + len(S0.h)\nS0.last = v",
    ),
    "frozen dataclass": reward(
        "from dataclasses import dataclass, replace\n@dataclass(frozen=True, slots=True)\n"
        "class S:\n    last: float = 0.0",
        "s = getattr(self, 's', S())\nk = v - s.last\nself.s = replace(s, last=v)",
    ),
    "default factory": reward(
        "import dataclasses\n@dataclasses.dataclass\nclass S:\n"
        "    n: int = dataclasses.field(default_factory=lambda m=[]: m.append(1) or len(m))",
        "k = 1.0 / S().n",
    ),
    "named tuple": reward(
        "from collections import namedtuple\nP = namedtuple('P', 'a b')\np = P(0.0, [])",
        "global p\np = p._replace(a=p.a * 0.5 + v)\np.b.append(v)\nk = p.a + len(p.b)",
    ),
    "typed named tuple": reward(
        "from typing import NamedTuple\nclass P(NamedTuple):\n    a: float = 0.0",
        "self.p = P(getattr(self, 'p', P()).a + v)\nk = self.p.a",
    ),
    "subclass of list": reward(
        "class L(list):\n    def mean(self):\n        return sum(self) / len(self)\nH = L()\n"
        "H.name = 'x'",
        "H.append(v)\nk = H.mean()\nH.name += 'y'\nk += len(H.name)",
    ),
    "subclass of dict": reward(
        "class D(dict):\n    def __missing__(self, key):\n        return 0.0\nd = D()",
        "d['k'] += v\nk = d['k']",
    ),
    "subclass of float": reward(
        "class F(float):\n    pass\nlast = F(0)",
        "global last\nk = last.n if hasattr(last, 'n') else 0.0\nlast = F(v)\nlast.n = v",
    ),
    "deque": reward(
        "from collections import deque\nH = deque(maxlen=5)", "H.append(v)\nk = sum(H)"
    ),
    "counter": reward(
        "from collections import Counter\nC = Counter()", "C[v > 0] += 1\nk = C[True] - C[False]"
    ),
    "default dict": reward(
        "from collections import defaultdict\nD = defaultdict(list)",
        "D[v > 0].append(v)\nk = sum(D[True])",
    ),
    "ordered dict": reward(
        "from collections import OrderedDict\nD = OrderedDict(a=0.0, b=1.0)",
        "D.move_to_end(next(iter(D)))\nk = D['a'] + list(D).index('a')\nD['a'] = v",
    ),
    "simple namespace": reward(
        "from types import SimpleNamespace\ns = SimpleNamespace(last=0.0)",
        "k = v - s.last\ns.last = v",
    ),
    "a set that never changes": reward("S = {1, 2}\nF = frozenset('ab')", "k = len(S) * v"),
    "bytearray": reward("B = bytearray(4)", "B[0] = (B[0] + 1) % 256\nk = B[0] / 256"),
    "array in place": reward("A = np.zeros(4)", "A[1:] = A[:-1]\nA[0] = v\nk = A.mean()"),
    "array by columns": reward(
        "A = np.zeros((3, 2), order='F')", "A[:] *= 0.5\nA[1] += v\nk = A.sum()"
    ),
    "view of an array": reward("A = np.zeros(4)\nT = A[::-2]", "T[:] += v\nk = A @ np.arange(4)"),
    "one list, two names": reward("H = []", "self.h = H\nself.h.append(v)\nk = sum(H) / len(H)"),
    "one array, two names": reward("A = np.zeros(3)", "self.a = A\nself.a[0] += v\nk = A[0]"),
    "a list that holds itself": reward("H = [0.0]\nH.append(H)", "H[1][0] += v\nk = H[0]"),
    "objects that know each other": reward(
        "class N:\n    def __init__(self):\n        self.other, self.n = None, 0.0\n"
        "a, b = N(), N()\na.other, b.other = b, a",
        "a.other.n += v\nk = b.n + b.other.other.n",
    ),
    "random generator": reward("R = np.random.default_rng(3)", "k = R.normal() + v"),
    "the simulation's generator": reward("", "k = self.np_random.normal()"),
    "generator kept in self": reward("", "self.r = self.np_random\nk = self.r.normal()"),
    "partial": reward(
        "from functools import partial\ndef push(h, v):\n    h.append(v)\n    return sum(h)\n"
        "f = partial(push, [])",
        "k = f(v)",
    ),
    "cached property": reward(
        "from functools import cached_property\nclass S:\n    def __init__(self, v):\n"
        "        self.v = v\n    @cached_property\n    def first(self):\n        return self.v",
        "if not hasattr(self, 's'): self.s = S(v)\nk = self.s.first",
    ),
    "enum": reward(
        "import enum\nclass Gait(enum.Enum):\n    A = 1\n    B = 2\nnow = Gait.A",
        "global now\nnow = Gait.B if now is Gait.A else Gait.A\nk = float(now is Gait.A) + v",
    ),
    "attribute of an enum": reward(
        "import enum\nclass Gait(enum.Enum):\n    A = 1\nGait.A.n = 0.0",
        "Gait.A.n += v\nk = Gait.A.n",
    ),
    "whole numbers without end": reward("n = 1", "global n\nn *= 12345\nk = float(n % 1001)"),
    "text": reward("s = ''", "global s\ns += 'ab'[v > 0]\nk = float(s.count('a'))"),
    "not a number": reward("H = [float('nan')]", "k = 0.0 if H[0] != H[0] else v\nH[0] = v"),
    "self in a helper": reward(
        "class T:\n    def __init__(self, robot):\n        self.robot, self.last = robot, 0.0\n"
        "    def step(self):\n        was, self.last = self.last, self.robot.data.qpos[0]\n"
        "        return float(self.last - was)",
        "if not hasattr(self, 't'): self.t = T(self)\nk = self.t.step()",
    ),
    "data in a helper": reward(
        "class T:\n    pass",
        "if not hasattr(self, 't'):\n    self.t = T()\n    self.t.data = self.data\n"
        "k = float(self.t.data.qvel[0])",
    ),
    "copy of the state": reward(
        "",
        "q = self.data.qpos\nk = float(np.abs(q - getattr(self, 'q', q)).sum())\n"
        "self.q = self.data.qpos.copy()",
    ),
    "the last action": reward(
        "",
        "k = float(np.abs(action - getattr(self, 'a', 0 * action)).sum())\nself.a = action",
    ),
    "part of the last action": reward(
        "", "k = float(getattr(self, 'a', action[:1])[0])\nself.a = action[:1]"
    ),
    "an attribute of the robot": reward(
        "", "k = float(self._reset_noise_scale)\nself._reset_noise_scale = v"
    ),
    "an attribute taken away": reward(
        "", "k = 1.0 if hasattr(self, 'init_qvel') else v\nif k == 1.0: del self.init_qvel"
    ),
    "a constant of the model": reward(
        "", "if not hasattr(self, 'm'): self.m = self.model.body_mass\nk = v * self.m.sum()"
    ),
    "steps of training": reward("", "k = self.training_steps / 1000"),
}
"""By the place: rewards that go on after a checkpoint as if there had been none."""

REFUSED = {
    "set": (reward("S = set()", "S.add(round(v, 2))\nk = float(len(S))"), "a set, whose order"),
    "set in self": (reward("", "self.s = {v}\nk = v"), "`self.s`"),
    "generator": (
        reward(
            "def g():\n    n = 0\n    while n < 1e9:\n        yield n\n        n += 1\nG = g()",
            "k = next(G)",
        ),
        "a generator",
    ),
    "generator in self": (
        reward("", "if not hasattr(self, 'g'): self.g = (i for i in range(99))\nk = next(self.g)"),
        "`self.g`",
    ),
    "count": (reward("import itertools\nC = itertools.count()", "k = next(C) * v"), "(count)"),
    "cycle": (
        reward("from itertools import cycle\nC = cycle([1, -1])", "k = next(C) * v"),
        "(cycle)",
    ),
    "iterator": (reward("I = iter(range(10**6))", "k = next(I) * v"), "iterator"),
    "lru_cache": (
        reward(
            "import functools\n@functools.lru_cache\ndef m():\n    return []",
            "m().append(v)\nk = sum(m())",
        ),
        "cache",
    ),
    "cache of a method": (
        reward(
            "import functools\nclass S:\n    @functools.cache\n    def m(self):\n"
            "        return []\ns = S()",
            "s.m().append(v)\nk = sum(s.m())",
        ),
        "cache",
    ),
    "view of the simulation": (
        reward(
            "",
            "q = self.data.qpos\nk = float((q - getattr(self, 'q', q)).sum())\nself.q = q",
        ),
        "a live view",
    ),
    "part of the simulation": (
        reward(
            "", "if not hasattr(self, 't'): self.t = self.data.body(1)\nk = float(self.t.xpos[0])"
        ),
        "a part of the simulation",
    ),
    "class made in a call": (
        reward(
            "", "if not hasattr(self, 's'):\n    class S:\n        n = 0\n    self.s = S()\nk = v"
        ),
        "`self.s`",
    ),
    "set of objects": (reward("class S:\n    pass\nA = {S(), S()}", "k = v"), "a set, whose order"),
    "objects in an array": (reward("A = np.array([None, 1])", "k = v"), "`A`"),
    "attribute of numpy": (
        reward("", "m = np\nm.memory = getattr(np, 'memory', 0.0) + 1\nk = m.memory"),
        "changes `numpy.memory`",
    ),
    "np.random": (reward("", "k = np.random.rand()"), "it is one generator for everything"),
    "generator without a seed": (
        reward("R = np.random.default_rng()", "k = R.normal()"),
        "needs a seed",
    ),
    "table of numpy": (
        reward("", "np.typecodes[v] = 1\nk = float(len(np.typecodes))"),
        "does not support item assignment",
    ),
    "Python's global generator": (
        reward("import statistics", "k = statistics.random.random()"),
        "cannot use `statistics.random`",
    ),
    "Python's global generator in a distribution": (
        reward("from statistics import NormalDist", "k = NormalDist().samples(1)[0]"),
        "needs a `seed`",
    ),
    "overloads": (
        reward("import typing", "typing.overload(_get_rew)\nk = v"),
        "cannot use `typing.overload`",
    ),
    "list in a type": (
        reward(
            "from typing import Annotated, get_args\nA = Annotated[float, []]",
            "get_args(A)[1].append(v)\nk = sum(get_args(A)[1])",
        ),
        "`A`",
    ),
    "list in a call of a method": (
        reward(
            "import operator\nclass B:\n    def use(self, it): return it\n"
            "M = operator.methodcaller('use', [])",
            "M(B()).append(v)\nk = sum(M(B()))",
        ),
        "`M`",
    ),
    "metadata of a field": (
        reward(
            "import dataclasses as dc\n@dc.dataclass\nclass S:\n"
            "    a: float = dc.field(default=0.0, metadata={'h': []})",
            "h = dc.fields(S)[0].metadata['h']\nh.append(v)\nk = sum(h)",
        ),
        "`S.a` has metadata",
    ),
    "metadata of a dtype": (
        reward(
            "D = np.dtype(float, metadata={'h': []})",
            "D.metadata['h'].append(v)\nk = sum(D.metadata['h'])",
        ),
        "a dtype with metadata",
    ),
    "list of a static method": (
        reward("m = staticmethod(max)\nm.h = []", "m.h.append(v)\nk = sum(m.h)"),
        "`m`",
    ),
    "list of a type variable": (
        reward(
            "from typing import TypeVar\nT = TypeVar('T')\nT.h = []", "T.h.append(v)\nk = sum(T.h)"
        ),
        "`T`",
    ),
    "attribute of a subclass of a number": (
        reward("class F(np.float64):\n    pass\nx = F(1)\nx.h = []", "x.h.append(v)\nk = sum(x.h)"),
        "`x`",
    ),
    "attribute of the simulation": (
        reward(
            "from operator import attrgetter",
            "d = attrgetter('__dict__')(self.data)\nd['n'] = k = d.get('n', 0.0) + v",
        ),
        "cannot read `__dict__`",
    ),
    "attribute of a function of the simulation": (
        reward("", "self.data.body.n = v\nk = v"),
        "no attribute 'n'",
    ),
    "setting of numpy": (
        reward(
            "def g():\n    with np.errstate(divide='raise'):\n        yield",
            "if self.training_steps == 4:\n    box = [g()]\n    box.append(box)\n    next(box[0])\n"
            "k = float(np.geterr()['divide'] == 'raise')",
        ),
        "changes `np.errstate`",
    ),
    "module of its own in a type": (
        reward(
            "from typing import Annotated, get_args\nA = Annotated[float, type(np)('m')]",
            "m = get_args(A)[1]\nk = m.n = getattr(m, 'n', 0.0) + v",
        ),
        "`A`",
    ),
    "memory of the simulation": (
        reward("", "self.data.userdata.base.obj[:] = v\nk = v"),
        "no attribute 'obj'",
    ),
    "address": (
        reward("", "k = float(id(object()) % 1000003) + id(self) % 999983"),
        "other numbers",
    ),
}
"""By the place: rewards that are refused, and a part of what is said."""

CONTENTS = {
    "list": ("[]", "c.append(v)\nk = sum(c[-3:])"),
    "dict": ("{'a': 0.0}", "c['a'] = 0.5 * c['a'] + v\nk = c['a']"),
    "deque": ("deque(maxlen=3)", "c.append(v)\nk = sum(c)"),
    "counter": ("Counter()", "c[v > 0] += 1\nk = c[True] - c[False]"),
    "array": ("np.zeros(3)", "c[:] = 0.9 * c + v * np.arange(3)\nk = c.sum()"),
    "part of an array": ("np.zeros((4, 3))[1:, ::2]", "c += v\nk = c.base.sum()"),
    "generator": ("np.random.default_rng(1)", "k = c.normal()"),
    "object": ("Box(0.0)", "c.n = 0.5 * c.n + v\nk = c.n"),
    "object in slots": ("Slim(0.0)", "c.n = 0.5 * c.n + v\nk = c.n"),
    "function": ("counting()", "k = c() * v"),
    "nested": ("([{}], Box([]))", "c[0][0][len(c[1].n)] = v\nc[1].n.append(v)\nk = sum(c[1].n)"),
}
"""By kind: how it is made, and how `k` is computed of it and of `v`, so that it changes."""

HOLDERS = {
    "name": ("X = {new}", "k = use(X, v)"),
    "self": ("", "if not hasattr(self, 'x'): self.x = {new}\nk = use(self.x, v)"),
    "default": ("def f(v, m={new}):\n    return use(m, v)", "k = f(v)"),
    "keyword default": ("def f(v, *, m={new}):\n    return use(m, v)", "k = f(v)"),
    "attribute of a function": ("def f(): pass\nf.m = {new}", "k = use(f.m, v)"),
    "closure": (
        "def make():\n    c = {new}\n    def f(v): return use(c, v)\n    return f\nf = make()",
        "k = f(v)",
    ),
    "class": ("class A:\n    m = {new}", "k = use(A.m, v)"),
    "object": ("class A:\n    def __init__(self): self.m = {new}\na = A()", "k = use(a.m, v)"),
    "slot": (
        "class A:\n    __slots__ = ('m',)\na = A()\na.m = {new}",
        "k = use(a.m, v)",
    ),
    "dict": ("X = {{'a': [{new}]}}", "k = use(X['a'][0], v)"),
    "tuple": ("X = (1, ({new},))", "k = use(X[1][0], v)"),
    "deque": ("X = deque([{new}])", "k = use(X[0], v)"),
    "partial": ("f = partial(use, {new})", "k = f(v)"),
    "method": (
        "class A:\n    def __init__(self): self.m = {new}\n"
        "    def f(self, v): return use(self.m, v)\nf = A().f",
        "k = f(v)",
    ),
    "dataclass": (
        "@dataclass\nclass A:\n    m: object = field(default_factory=lambda: {new})\na = A()",
        "k = use(a.m, v)",
    ),
    "default factory": ("D = defaultdict(lambda: {new})", "k = use(D['a'], v)"),
    "object of a class made of a list": ("class L(list): pass\nX = L([{new}])", "k = use(X[0], v)"),
    "self and a name": (
        "X = {new}",
        "self.x = X if not hasattr(self, 'x') else self.x\nk = use(self.x, v) + use(X, v)",
    ),
}
"""By kind: how something is put there, and how it is used."""

_HEADER = """
from collections import Counter, defaultdict, deque
from dataclasses import dataclass, field
from functools import partial
class Box:
    def __init__(self, n): self.n = n
class Slim:
    __slots__ = ("n",)
    def __init__(self, n): self.n = n
def counting():
    n = 0
    def step():
        nonlocal n
        n += 1
        return n
    return step
def use(c, v):
"""


def held(holder: str, content: str) -> str:
    """Return a reward that keeps a kind of content in a kind of place."""
    new, use = CONTENTS[content]
    setup, body = (part.format(new=new) for part in HOLDERS[holder])
    return reward(
        f"{_HEADER.strip()}\n{textwrap.indent(use, '    ')}\n    return float(k)\n{setup}", body
    )


CONSTANTS = reward(
    """
    import abc, collections, dataclasses, enum, functools, itertools, math, operator, statistics
    import numpy.linalg as la
    from collections import ChainMap, UserDict, namedtuple
    from typing import Any, Callable, Dict, Final, Generic, NamedTuple, Optional, Protocol, TypeVar
    from numpy.typing import NDArray
    T = TypeVar("T")
    Terms = Dict[str, float]
    Pair, Maybe, Vector, Either = dict[str, float], Optional[float], NDArray[np.float64], int | None
    norm, add, last, sine, out = la.norm, np.add.reduce, operator.itemgetter(-1), math.sin, print
    INDEX, EVERY, DTYPE, PI = slice(1, None), range(3), np.dtype(np.float32), np.pi
    NAMES, IDS = frozenset("abc"), {1: "a", (2, 3): {"b": [None, ..., True]}}
    _MISSING = object()
    class Shape(Protocol):
        def size(self) -> float: ...
    class Base(abc.ABC, Generic[T]):
        @abc.abstractmethod
        def value(self): ...
    class Own(Base[float]):
        limit: Final = 3.0
        def value(self):
            return self.limit
    class Gait(enum.IntFlag):
        LEFT = 1
        RIGHT = 2
    @functools.total_ordering
    @dataclasses.dataclass(frozen=True, eq=True)
    class Weights:
        a: float = 1.0
        b: tuple = (1.0, 2.0)
        def __lt__(self, other):
            return self.a < other.a
    class Wrong(Exception):
        pass
    class Meta(type):
        made = []
        def make(cls):
            cls.made.append(1)
            return cls()
    class Made(metaclass=Meta):
        pass
    class Field:
        def __get__(self, owner, kind=None):
            return 2.0
    class Described:
        f = Field()
    own, weights, chain, both = Own(), Weights(), ChainMap({"a": 1.0}), Gait.LEFT | Gait.RIGHT
    described, table = Described(), UserDict(a=2.0)
    """,
    """
    Made.make()
    k = own.value() * v + weights.b[1] + chain["a"] + float(both) + described.f + len(Meta.made)
    k += sum(itertools.accumulate(EVERY)) + statistics.fmean([v, k]) + table["a"] + norm(action)
    """,
)
"""A reward with everything at its top level that is usual there."""


_LATE = "if self.training_steps > 56:\n    "
_BUMP = """
import abc, dataclasses
from collections import Counter, namedtuple
from enum import Enum
from numbers import Number
from statistics import fmean
from typing import TypeVar
import functools
def bump(c):
    c.n = getattr(c, "n", 0) + 1
class E(Enum):
    A = 1
class C:
    _abc_impl = 0
    def __init__(self):
        self.n = 0
class Derived(C):
    pass
class M(type):
    n = 0
class S(metaclass=M):
    n = 0
    held = {}
    kind = C
    @classmethod
    def add(cls):
        cls.n += 1
def other(self):
    self.n = 5
class Abstract(abc.ABC):
    pass
@dataclasses.dataclass
class Data:
    n: float = 0.0
domain = np.polynomial.Polynomial.domain
T = TypeVar("T")
N = namedtuple("N", "a b")
f = functools.partial(max, 1)
m = staticmethod(max)
E.many = []
s, R = S(), np.random.default_rng(1)
"""

LATE_KEPT = {
    name: reward(_BUMP, f"{_LATE}{change}\nk = float({use})")
    for name, (change, use) in {
        "class of an instance": ("bump(type(s))", "S.n"),
        "class method": ("S.add()", "S.n"),
        "dict in a class": ("s.held['n'] = len(s.held) + S.held.get('n', 0)", "s.held.get('n', 0)"),
        "class in a class": ("bump(S.kind)", "getattr(C, 'n', 0)"),
        "metaclass": ("M.n += 1", "S.n + type(S).n"),
        "enumeration": ("bump(E)", "getattr(E, 'n', 0)"),
        "list in an enumeration": ("E.many.append(v)", "len(E.many)"),
        "member of an enumeration": ("bump(E.A)", "getattr(E.A, 'n', 0)"),
        "name of Python's own": ("C._abc_impl += 1", "C._abc_impl"),
        "named tuple": ("bump(N)", "getattr(N, 'n', 0)"),
    }.items()
}
"""By the place, one that is first used late: what is kept there survives."""

LATE_REFUSED = {
    name: reward(_BUMP, f"{_LATE}{change}\nk = float({use})")
    for name, (change, use) in {
        "SwimmerEnvironment.n": ("bump(type(self))", "getattr(type(self), 'n', 0)"),
        "RobotEnvironment.n": ("bump(type(self).mro()[2])", "getattr(type(self), 'n', 0)"),
        "SwimmerEnv.metadata": ("type(self).metadata[v] = 1", "len(type(self).metadata)"),
        "numpy.mean.n": ("bump(np.mean)", "getattr(np.mean, 'n', 0)"),
        "numpy.poly1d.n": ("bump(np.poly1d)", "getattr(np.poly1d, 'n', 0)"),
        "numpy.n": ("bump(np)", "getattr(np, 'n', 0)"),
        "collections.Counter.n": ("bump(Counter)", "getattr(Counter, 'n', 0)"),
        "T.n": ("bump(T)", "getattr(T, 'n', 0)"),
        "`f`": ("bump(f)", "getattr(f, 'n', 0)"),
        "max.n": ("bump(m)", "getattr(m, 'n', 0)"),
        "_replace.n": ("bump(N._replace)", "getattr(N._replace, 'n', 0)"),
        "other.__name__": ("other.__name__ += 'x'", "len(other.__name__)"),
        "C.__init__": ("C.__init__ = other", "C().n"),
        "changes `E`": ("E._value2member_map_[7] = v", "E._value2member_map_.get(7, 0)"),
        "changes `numbers.Number`": ("Number.register(C)", "isinstance(C(), Number)"),
        "changes `Abstract`": ("Abstract.register(C)", "isinstance(C(), Abstract)"),
        "changes `Data`": ("dataclasses.fields(Data)[0].compare = v", "v"),
        "Derived.__bases__": ("Derived.__bases__ = (Data,)", "v"),
        "Abstract.__abstractmethods__": (
            "Abstract.f = abc.abstractmethod(other); abc.update_abstractmethods(Abstract)",
            "v",
        ),
        "Polynomial.domain": ("domain[0] = v", "domain[0]"),
        "fmean.__wrapped__": ("functools.update_wrapper(fmean, other, assigned=())", "v"),
        "self.__class__": ("self.__class__ = type('R', (type(self),), {})", "v"),
        "self.np_random": ("self.np_random.spawn(1)", "v"),
        "`R`": ("R.spawn(1)", "v"),
    }.items()
}
"""By what is said: rewards that late change something that no checkpoint holds."""
