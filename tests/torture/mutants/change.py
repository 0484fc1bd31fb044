"""One fault in a module: another operator, constant or condition."""

from __future__ import annotations

import ast
import copy
import random
from dataclasses import dataclass

OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Pow: ast.Mult,
    ast.Mod: ast.FloorDiv, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.And: ast.Or, ast.Or: ast.And,
    ast.Lt: ast.LtE, ast.LtE: ast.Gt, ast.Gt: ast.GtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
NAMES = {"max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum", "any": "all", "all": "any",
         "sin": "cos", "cos": "sin", "argmax": "argmin", "argmin": "argmax"}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """A module with one fault."""

    line: int
    before: str
    after: str
    source: str


def mutants(source: str) -> list[int]:
    """The places where a module can be changed, as numbers for `mutant`."""
    return list(range(len(_places(ast.parse(source)))))


def mutant(source: str, place: int, seed: int) -> Mutant:
    """The module with the fault at one place; the seed decides where there are several."""
    tree = ast.parse(source)
    node = _places(tree)[place]
    before = ast.unparse(node)
    line = getattr(node, "lineno", 0)
    _change(node, random.Random(seed))  # noqa: S311 - nothing is guarded
    return Mutant(line, before, ast.unparse(node), ast.unparse(ast.fix_missing_locations(tree)) + "\n")


def _places(tree: ast.Module) -> list[ast.AST]:
    """Every node that can be changed. Types, decorators and assertions are left out: what users get
    does not depend on them."""
    found: list[ast.AST] = []
    for statement in tree.body:
        is_alias = isinstance(statement, ast.Assign) and isinstance(statement.value, ast.BinOp)
        if not (is_alias and isinstance(statement.value.op, ast.BitOr)):
            _walk(statement, found)
    return found


def _walk(node: ast.AST, found: list[ast.AST]) -> None:
    if isinstance(node, ast.Assert | ast.Import | ast.ImportFrom):
        return
    if _can_change(node):
        found.append(node)
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns", "decorator_list"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    _walk(child, found)


def _can_change(node: ast.AST) -> bool:
    match node:
        case ast.BinOp() | ast.BoolOp():
            return type(node.op) in OPERATORS
        case ast.Compare():
            return True
        case ast.UnaryOp():
            return isinstance(node.op, ast.USub | ast.Not)
        case ast.Constant():
            return isinstance(node.value, bool | int | float)
        case ast.If() | ast.IfExp() | ast.While():
            return not isinstance(node.test, ast.Compare | ast.BoolOp | ast.UnaryOp)  # these are places of their own
        case ast.Attribute():
            return node.attr in NAMES
        case ast.Name():
            return node.id in NAMES
    return False


def _change(node: ast.AST, chance: random.Random) -> None:
    match node:
        case ast.BinOp() | ast.BoolOp():
            node.op = OPERATORS[type(node.op)]()
        case ast.Compare():
            at = chance.randrange(len(node.ops))
            node.ops[at] = OPERATORS[type(node.ops[at])]()
        case ast.UnaryOp():
            node.op = ast.UAdd() if isinstance(node.op, ast.USub) else ast.USub()
            if isinstance(node.op, ast.USub):  # `not x` becomes `x`
                operand = copy.copy(node.operand)
                node.op, node.operand = ast.Not(), ast.UnaryOp(ast.Not(), operand)
        case ast.Constant():
            node.value = _constant(node.value, chance)
        case ast.If() | ast.IfExp() | ast.While():
            node.test = ast.UnaryOp(ast.Not(), node.test)
        case ast.Attribute():
            node.attr = NAMES[node.attr]
        case ast.Name():
            node.id = NAMES[node.id]


def _constant(value: object, chance: random.Random) -> object:
    match value:
        case bool():
            return not value
        case int():
            return value + chance.choice((-1, 1))
        case float():
            return chance.choice((1.1, 0.9)) * value if value else 1.0
    raise TypeError(value)
