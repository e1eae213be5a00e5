"""Translate a module's syntax tree so that its numbers may be arrays."""

import ast
from itertools import count

_LANES = "_lanes"
"""The name of the module `masks` in the translated code."""
_IN_PLACE = {"append", "extend", "insert", "remove", "pop", "popleft", "clear", "update", "add",
             "discard", "setdefault"}  # fmt: skip
_COMPOUND = (ast.If, ast.While, ast.For, ast.With)
_BEYOND = (ast.Try, ast.TryStar, ast.Match, ast.AsyncFunctionDef, ast.Global, ast.Nonlocal,
           ast.Yield, ast.YieldFrom, ast.Await)  # fmt: skip
"""Statements that the model does not use; they cannot be executed for only some lanes."""


def translated(tree: ast.Module) -> ast.Module:
    """Return the tree of a module, translated."""
    _Lanes().visit(tree)
    return ast.fix_missing_locations(tree)


def _member(holder: str, name: str) -> ast.Attribute:
    return ast.Attribute(ast.Name(holder, ast.Load()), name, ast.Load())


def _method(holder: str, name: str, *arguments: ast.expr) -> ast.Call:
    return ast.Call(_member(holder, name), list(arguments), [])


def _call(name: str, *arguments: ast.expr) -> ast.Call:
    return _method(_LANES, name, *arguments)


def _later(value: ast.expr) -> ast.Lambda:
    nothing = ast.arguments(posonlyargs=[], args=[], kwonlyargs=[], kw_defaults=[], defaults=[])
    return ast.Lambda(nothing, value)


def _returns(body: list[ast.stmt]) -> bool:
    """Return whether a block returns, its inner functions left out."""
    for each in body:
        if isinstance(each, ast.Return):
            return True
        blocks = (getattr(each, name, []) for name in ("body", "orelse"))
        if isinstance(each, _COMPOUND) and any(map(_returns, blocks)):
            return True
    return False


def _stored(body: list[ast.stmt]) -> set[str]:
    """Return the local names that a block sets."""
    walked = (inner for each in body for inner in ast.walk(each))
    return {
        each.id for each in walked if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
    }


class _Lanes(ast.NodeTransformer):
    def __init__(self) -> None:
        self._numbers = count()
        self._frame = ""
        """Name of the function's frame variable; "" if it needs none."""
        self._functions = 0
        self._deep = 0
        """Number of compound statements around this one, within the function."""
        self._loop = ""
        """Name of the variable with the lanes that began this round of the innermost loop."""
        self._own = ""
        """First argument of the innermost function, for `super`, also within a lambda."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        before = self._frame, self._deep, self._loop, self._own
        self._own = node.args.args[0].arg if node.args.args else ""
        self._functions += 1
        parts = [each for each in node.body if isinstance(each, _COMPOUND)]
        self._frame = self._new("frame") if parts else ""
        self._deep, self._loop = 0, ""
        body = self._block(node.body)
        if self._frame:
            arguments = node.args
            given = {each.arg for each in (*arguments.posonlyargs, *arguments.args,
                                           *arguments.kwonlyargs)}  # fmt: skip
            begin: list[ast.stmt] = [_assign(self._frame, _call("Frame"))]
            unset = _member(_LANES, "UNSET")
            begin += [_assign(name, unset) for name in sorted(_stored(list(parts)) - given)]
            body = [*begin, *body, ast.Return(_method(self._frame, "end"))]
        self._frame, self._deep, self._loop, self._own = before
        self._functions -= 1
        node.body = body
        return node

    # ---- statements ----

    def _block(self, body: list[ast.stmt]) -> list[ast.stmt]:
        """Translate a block: after a statement that may return, only the remaining lanes go on."""
        done: list[ast.stmt] = []
        for place, statement in enumerate(body):
            found = self.visit(statement)
            done += found if isinstance(found, list) else [found]
            rest = body[place + 1 :]
            if rest and isinstance(statement, _COMPOUND) and _returns([statement]):
                goes_on = _method(self._frame, "goes_on")
                return [*done, ast.If(goes_on, self._block(rest), [])]
        return done

    def _inner(self, body: list[ast.stmt]) -> list[ast.stmt]:
        self._deep += 1
        found = self._block(body)
        self._deep -= 1
        return found

    def visit_If(self, node: ast.If) -> ast.stmt:
        test = self.visit(node.test)
        if not self._frame:  # at the top of a module
            node.test, node.body, node.orelse = test, self._block(node.body), node.orelse
            return node
        way = self._new("way")
        inner = ast.If(ast.Name(way, ast.Load()), self._inner(node.body), self._inner(node.orelse))
        return ast.For(ast.Name(way, ast.Store()), _call("split", test), [inner], [])

    def visit_While(self, node: ast.While) -> list[ast.stmt]:
        name, before = self._new("while"), self._loop
        self._loop = self._new("round")
        node.test = _method(name, "again", self.visit(node.test))
        node.body = [_assign(self._loop, _now()), *self._inner(node.body)]
        self._loop = before
        return [_assign(name, _call("While")), node, ast.Expr(_method(name, "end"))]

    def visit_For(self, node: ast.For) -> ast.stmt:
        before, self._loop = self._loop, self._new("round")
        node.iter = self.visit(node.iter)
        begin: list[ast.stmt] = []
        if _returns(node.body):
            ends = ast.UnaryOp(ast.Not(), _method(self._frame, "goes_on"))
            begin.append(ast.If(ends, [ast.Break()], []))
        node.body = [*begin, _assign(self._loop, _now()), *self._inner(node.body)]
        self._loop = before
        return node

    def visit_Break(self, node: ast.Break | ast.Continue) -> list[ast.stmt]:
        return [ast.Expr(_call("together", ast.Name(self._loop, ast.Load()))), node]

    def visit_Continue(self, node: ast.Continue) -> list[ast.stmt]:
        return self.visit_Break(node)

    def visit_Raise(self, node: ast.Raise) -> ast.stmt:
        self.generic_visit(node)
        return ast.If(_call("raises"), [node], [])

    def visit_Return(self, node: ast.Return) -> ast.stmt | list[ast.stmt]:
        value = self.visit(node.value) if node.value else ast.Constant(None)
        if not self._frame:
            return ast.Return(value)
        if not self._deep:
            return ast.Return(_method(self._frame, "end", value))
        name = self._new("value")
        return [
            _assign(name, value),
            ast.If(_method(self._frame, "is_whole"), [ast.Return(ast.Name(name, ast.Load()))], []),
            ast.Expr(_method(self._frame, "leave", ast.Name(name, ast.Load()))),
        ]

    def visit_Assign(self, node: ast.Assign) -> list[ast.stmt]:
        value = self.visit(node.value)
        if len(node.targets) == 1 and not isinstance(node.targets[0], ast.Tuple):
            return [self._store(node.targets[0], value)]
        name = self._new("value")
        done: list[ast.stmt] = [_assign(name, value)]
        for target in node.targets:
            done += self._unpacked(target, ast.Name(name, ast.Load()))
        return done

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt:
        if node.value is None or (not self._frame and isinstance(node.target, ast.Name)):
            node.value = node.value and self.visit(node.value)
            return node
        return self._store(node.target, self.visit(node.value))

    def visit_Delete(self, node: ast.Delete) -> ast.stmt:
        for target in node.targets:
            assert isinstance(target, ast.Subscript)  # noqa: S101 - no name, no attribute
            target.value = _call("common", self.visit(target.value))
        return node

    def generic_visit(self, node: ast.AST) -> ast.AST:
        """Translate the parts of any other node that the model may use."""
        if isinstance(node, _BEYOND):
            raise NotImplementedError(f"{type(node).__name__} in line {node.lineno} of the model")
        return super().generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        before = ast.parse(ast.unparse(node.target), mode="eval").body
        return self._store(
            node.target, ast.BinOp(self.visit(before), node.op, self.visit(node.value))
        )

    def _unpacked(self, target: ast.expr, value: ast.expr) -> list[ast.stmt]:
        if not isinstance(target, ast.Tuple):
            return [self._store(target, value)]
        names = [self._new("part") for _ in target.elts]
        parts: list[ast.expr] = []
        done: list[ast.stmt] = []
        for name, each in zip(names, target.elts, strict=True):
            stored = ast.Name(name, ast.Store())
            starred = isinstance(each, ast.Starred)
            parts.append(ast.Starred(stored, ast.Store()) if starred else stored)
            inner = each.value if isinstance(each, ast.Starred) else each
            done += self._unpacked(inner, ast.Name(name, ast.Load()))
        return [ast.Assign([ast.Tuple(parts, ast.Store())], value), *done]

    def _store(self, target: ast.expr, value: ast.expr) -> ast.stmt:
        if isinstance(target, ast.Attribute):
            name = ast.Constant(target.attr)
            return ast.Expr(_call("put", self.visit(target.value), name, value))
        if isinstance(target, ast.Subscript):
            holder, key = self.visit(target.value), self.visit(target.slice)
            return ast.Expr(_call("put_item", holder, key, value))
        if self._deep and self._frame and isinstance(target, ast.Name):
            value = _method(self._frame, "set", ast.Name(target.id, ast.Load()), value)
        return ast.Assign([target], value)

    # ---- expressions ----

    def visit_BoolOp(self, node: ast.BoolOp) -> ast.expr:
        is_and = isinstance(node.op, ast.And)
        *first, found = node.values
        right: ast.expr = self.visit(found)
        for each in reversed(first):
            calls = any(isinstance(part, ast.Call) for part in ast.walk(right))
            plain = ("and_", "or_") if calls else ("both", "either")
            right = _call(plain[not is_and], self.visit(each), _later(right))
        return right

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        if isinstance(node.op, ast.Not):
            return _call("not_", self.visit(node.operand))
        self.generic_visit(node)
        return node

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        ways = (_later(self.visit(each)) for each in (node.body, node.orelse))
        return _call("choose", self.visit(node.test), *ways)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        self.generic_visit(node)
        first, right = node.ops[0], node.comparators[0]
        if isinstance(first, ast.In | ast.NotIn) and isinstance(right, ast.Tuple):
            found = _call("among", node.left, right)
            return found if isinstance(first, ast.In) else _call("not_", found)
        is_none = isinstance(right, ast.Constant) and right.value is None
        if isinstance(first, ast.Is | ast.IsNot) and is_none:
            found = _call("is_none", node.left)
            return found if isinstance(first, ast.Is) else _call("not_", found)
        if len(node.ops) == 1:
            return node
        parts: list[ast.expr] = [node.left]
        table = _member(_LANES, "COMPARISONS")
        for compare, value in zip(node.ops, node.comparators, strict=True):
            kind = ast.Constant(type(compare).__name__)
            parts += [ast.Subscript(table, kind, ast.Load()), value]
        return _call("chain", *parts)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        self.generic_visit(node)
        fixed = isinstance(node.slice, ast.Constant | ast.Slice | ast.UnaryOp | ast.Tuple)
        if fixed or not self._functions:
            return node
        return _call("item", node.value, node.slice)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        self.generic_visit(node)
        if isinstance(node.func, ast.Attribute) and node.func.attr in _IN_PLACE:
            node.func.value = _call("common", node.func.value)
        if isinstance(node.func, ast.Name) and node.func.id == "super":
            node.args = [ast.Name("__class__", ast.Load()), ast.Name(self._own, ast.Load())]
        return node

    def _new(self, what: str) -> str:
        return f"_{what}_{next(self._numbers)}"


def _assign(name: str, value: ast.expr) -> ast.stmt:
    return ast.Assign([ast.Name(name, ast.Store())], value)


def _now() -> ast.expr:
    return ast.Attribute(_member(_LANES, "NOW"), "active", ast.Load())
