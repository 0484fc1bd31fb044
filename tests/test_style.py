"""Code that can be read: one thought a line and plain docstrings, as far as code can check it."""

import ast
import builtins
import functools
import importlib.util
import re
import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "tendon_cli"
FOLDERS = ("tendon_cli", "tests", "tools", "benchmarks", "verification", "docs")
PYTHON = sorted(
    path
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*.py")
    if "_build" not in path.parts
)
OTHER_CODE = sorted(
    path
    for folder in ("kernel", "reports/page")
    for path in (PACKAGE / folder).iterdir()
    if path.suffix in (".c", ".h", ".js", ".css")
)
WIDTH = 100  # columns

LAID_OUT_BY_HAND = {
    "tendon_cli/quantities.py": "a quantity is a row: name, symbol, dimension, meaning",
    "tests/test_units.py": "a text, its dimension and its value are a row",
}
"""Tables of data that are read by rows, which the formatter leaves alone, and why."""

ODD_FIRST_WORDS = re.compile(
    r"(What|Of|Whether|How|Where|Which|Those|By|That|Whose|As|Some of|Each of|In which|If|Who"
    r"|When)\b"
)
"""First words that leave a docstring without a subject or a verb."""


def relative(path):
    return path.relative_to(ROOT).as_posix()


@functools.cache
def text_of(path):
    return path.read_text(encoding="utf-8")


@functools.cache
def nodes(path):
    return list(ast.walk(ast.parse(text_of(path))))


@pytest.fixture(scope="module", autouse=True)
def _forget_nodes():
    """Forget the millions of nodes after the module: the collector would visit them ever after."""
    yield
    nodes.cache_clear()
    text_of.cache_clear()


def findings(is_wrong, *kinds, files=PYTHON):
    """Return places in files at which a node of these kinds is wrong."""
    return [
        f"{relative(path)}:{node.lineno}: {ast.unparse(node)[:80]}"
        for path in files
        for node in nodes(path)
        if isinstance(node, kinds) and is_wrong(node)
    ]


def names_in(node):
    """Return names, attributes and items that an expression reads or writes, as text."""
    kinds = (ast.Name, ast.Attribute, ast.Subscript)
    return {ast.unparse(part) for part in ast.walk(node) if isinstance(part, kinds)}


def has_conditional(node):
    return any(isinstance(part, ast.IfExp) for part in ast.walk(node))


def test_an_assignment_packs_no_independent_values():
    def is_packed(node):
        target = node.targets[0]
        if not isinstance(target, ast.Tuple) or not isinstance(node.value, ast.Tuple):
            return False
        is_exchange = names_in(target) & names_in(node.value)  # a, b = b, a + b
        return not is_exchange

    assert findings(is_packed, ast.Assign) == []


def test_an_assignment_has_one_target():
    assert findings(lambda node: len(node.targets) > 1, ast.Assign) == []


def test_a_loop_goes_over_no_conditional():
    loops = (ast.For, ast.AsyncFor)
    assert findings(lambda loop: isinstance(loop.iter, ast.IfExp), *loops) == []

    def goes_over_conditional(node):
        return any(isinstance(part.iter, ast.IfExp) for part in node.generators)

    kinds = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)
    assert findings(goes_over_conditional, *kinds) == []


def test_a_condition_holds_no_conditional():
    assert findings(lambda node: has_conditional(node.test), ast.If, ast.While) == []

    def is_nested(node):
        return any(map(has_conditional, (node.test, node.body, node.orelse)))

    assert findings(is_nested, ast.IfExp) == []


STRINGS_AND_COMMENTS = re.compile(
    r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])*\'|`(\\.|[^`\\])*`|//.*|/\*[\s\S]*?\*/'
)


@pytest.mark.parametrize("path", OTHER_CODE, ids=relative)
def test_compiled_code_and_scripts_have_one_statement_a_line(path):
    text = STRINGS_AND_COMMENTS.sub("''", text_of(path))
    wrong = []
    for number, line in enumerate(text.splitlines(), start=1):
        outside = line
        for _ in range(5):  # brackets within brackets
            outside = re.sub(r"\([^()]*\)|\{[^{}]*\}|\[[^\[\]]*\]", "", outside)
        if outside.count(";") > 1 or re.search(r"=[^=,]*,[^=]*[\w\].]\s*[-+*/]?=[^=]", outside):
            wrong.append((number, line.strip()))
    assert path.suffix == ".css" or wrong == []


def test_lines_end_before_column_100():
    long = [
        f"{relative(path)}:{number}: {len(line)} columns"
        for path in [*PYTHON, *OTHER_CODE]
        if relative(path) not in LAID_OUT_BY_HAND
        for number, line in enumerate(text_of(path).splitlines(), start=1)
        if len(line) > WIDTH and "noqa: E501" not in line
    ]
    assert long == []


def test_only_tables_of_data_are_laid_out_by_hand():
    mark = "fmt: " + "skip"  # not to be found in this file
    files = {relative(path) for path in PYTHON if mark in text_of(path)}
    assert files == set(LAID_OUT_BY_HAND)
    assert not [relative(path) for path in PYTHON if "fmt: " + "off" in text_of(path)]


# --- Docstrings -----------------------------------------------------------------------------------


def docstrings(path):
    """Yield line and text of the docstrings of a file, those of fields and constants included."""
    for node in nodes(path):
        if isinstance(node, (ast.Lambda, ast.IfExp)):
            continue
        for statement in getattr(node, "body", []):
            value = getattr(statement, "value", None)
            is_text = isinstance(statement, ast.Expr) and isinstance(value, ast.Constant)
            if is_text and isinstance(value.value, str):
                yield statement.lineno, value.value


def test_a_docstring_begins_with_a_verb_or_a_noun():
    odd = [
        f"{relative(path)}:{line}: {text.strip().splitlines()[0][:70]}"
        for path in PYTHON
        for line, text in docstrings(path)
        if ODD_FIRST_WORDS.match(text.strip())
    ]
    assert odd == []


IDENTIFIER = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*(?=\(|$)")


@functools.cache
def known_names():
    """Return every name in the code of the project, and every word of its texts but docstrings."""
    known = {*dir(builtins), *sys.stdlib_module_names}
    for path in PYTHON:
        known |= {*path.relative_to(ROOT).with_suffix("").parts}
        explanations = {text for _, text in docstrings(path)}
        for node in nodes(path):
            known |= set(names_of(node)) - {None}
            is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
            if is_text and node.value not in explanations:
                known |= {*re.findall(r"\w+", node.value)}
    for path in OTHER_CODE:
        known |= {*re.findall(r"\w+", text_of(path))}
    return known


def names_of(node):
    """Return the names that a node of the syntax tree gives or uses."""
    match node:
        case ast.FunctionDef() | ast.ClassDef():
            return [node.name]
        case ast.Name():
            return [node.id]
        case ast.Attribute():
            return [node.attr]
        case ast.arg() | ast.keyword():
            return [node.arg]
        case ast.alias():
            return [*node.name.split("."), node.asname]
    return []


def test_every_name_in_backticks_exists():
    unknown = []
    for path in PYTHON:
        for line, text in docstrings(path):
            for quoted in re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text):
                match = IDENTIFIER.match(quoted)
                if match is None or match.group() not in (quoted, quoted.partition("(")[0]):
                    continue  # a command, a formula, or a key with its value
                parts = match.group().split(".")
                missing = [part for part in parts if part not in known_names()]
                if missing and importlib.util.find_spec(parts[0]) is None:
                    unknown.append(f"{relative(path)}:{line}: {quoted}")
    assert unknown == []


def test_no_two_modules_of_the_package_share_a_name():
    names = Counter(path.stem for path in PACKAGE.rglob("*.py") if path.stem != "__init__")
    assert [name for name, count in names.items() if count > 1] == []
