"""One fault in a module: another operator, constant or condition."""

from __future__ import annotations

import ast
import random
from dataclasses import dataclass
from typing import Any

OPERATORS = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Pow: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.And: ast.Or,
    ast.Or: ast.And,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
NAMES = {
    "max": "min",
    "min": "max",
    "maximum": "minimum",
    "minimum": "maximum",
    "any": "all",
    "all": "any",
    "sin": "cos",
    "cos": "sin",
    "argmax": "argmin",
    "argmin": "argmax",
}


@dataclass(frozen=True)
class Mutant:
    """A module with one fault."""

    line: int
    lines: range
    """Lines of the statement with the fault; of one with a body, those above the body."""
    is_in_function: bool
    before: str
    after: str
    source: str


def mutants(source: str) -> list[int]:
    """Return the places where a module can be changed, as numbers for `mutant`."""
    return list(range(len(_places(ast.parse(source)))))


def mutant(source: str, place: int, seed: int) -> Mutant:
    """Return the module with the fault at one place; the seed decides if there are several."""
    tree = ast.parse(source)
    node = _places(tree)[place]
    before = ast.unparse(node)
    line = getattr(node, "lineno", 0)
    lines, is_in_function = _place_of(tree, node)
    fault = _fault(node, random.Random(seed))  # noqa: S311 - nothing is guarded
    vars(node).update(fault or {})
    changed = ast.unparse(ast.fix_missing_locations(tree)) + "\n"
    return Mutant(line, lines, is_in_function, before, ast.unparse(node), changed)


def _place_of(tree: ast.Module, node: ast.AST) -> tuple[range, bool]:
    """Return the lines of the innermost statement that a node is in, and if it is in a function.

    Of a statement with a body its own lines are those above the body.
    """
    statements = [part for part in ast.walk(tree) if isinstance(part, ast.stmt)]
    around = [outer for outer in statements if any(part is node for part in ast.walk(outer))]
    innermost = around[-1]  # outer statements come first
    body = getattr(innermost, "body", None)
    end = body[0].lineno if body else (innermost.end_lineno or 0) + 1
    lines = range(innermost.lineno, max(end, innermost.lineno + 1))
    # The defaults of a function are worked out where it is defined.
    return lines, any(isinstance(statement, ast.FunctionDef) for statement in around[:-1])


def _places(tree: ast.Module) -> list[ast.AST]:
    """Return every node that can be changed.

    Types, decorators and assertions are left out: no user gets them.
    """
    places: list[ast.AST] = []
    for statement in tree.body:
        if not _is_alias(statement):
            _collect(statement, places)
    return places


def _is_alias(statement: ast.stmt) -> bool:
    """Return True for the union of types that a name stands for."""
    return (
        isinstance(statement, ast.Assign)
        and isinstance(statement.value, ast.BinOp)
        and isinstance(statement.value.op, ast.BitOr)
    )


def _collect(node: ast.AST, places: list[ast.AST]) -> None:
    """Add a node and the nodes below it that can be changed."""
    if isinstance(node, ast.Assert | ast.Import | ast.ImportFrom):
        return
    if _fault(node, random.Random(0)):  # noqa: S311 - nothing is guarded
        places.append(node)
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        children = value if isinstance(value, list) else [value]
        for child in children:
            if isinstance(child, ast.AST):
                _collect(child, places)


def _fault(node: ast.AST, rng: random.Random) -> dict[str, Any] | None:
    """Return the fields of a node that make it faulty, or None if it has no fault."""
    match node:
        case ast.BinOp(op=op) | ast.BoolOp(op=op) if type(op) in OPERATORS:
            return {"op": OPERATORS[type(op)]()}
        case ast.Compare(ops=ops):
            place = rng.randrange(len(ops))
            operator = OPERATORS[type(ops[place])]()
            return {"ops": [*ops[:place], operator, *ops[place + 1 :]]}
        case ast.UnaryOp(op=ast.USub()):
            return {"op": ast.UAdd()}
        case ast.UnaryOp(op=ast.Not(), operand=operand):  # `not x` becomes `x`
            return {"operand": ast.UnaryOp(ast.Not(), operand)}
        case ast.Constant(value=bool(value)):
            return {"value": not value}
        case ast.Constant(value=int(value)):
            return {"value": value + rng.choice((-1, 1))}
        case ast.Constant(value=float(value)):
            return {"value": rng.choice((1.1, 0.9)) * value or 1.0}
        case ast.If(test=test) | ast.IfExp(test=test) | ast.While(test=test):
            # These conditions are places of their own.
            is_place = isinstance(test, ast.Compare | ast.BoolOp | ast.UnaryOp)
            return None if is_place else {"test": ast.UnaryOp(ast.Not(), test)}
        case ast.Attribute(attr=name) if name in NAMES:
            return {"attr": NAMES[name]}
        case ast.Name(id=name) if name in NAMES:
            return {"id": NAMES[name]}
    return None
