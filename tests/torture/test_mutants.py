"""Mutants have one fault each, all of them different, and none where nothing runs."""

import ast

from tools.mutants.change import mutant, mutants

SOURCE = '''
Real = float | int


def f(x: "int | None" = 3) -> "bool | None":
    """Text."""
    assert x > 0
    if x:
        return not x
    return -x + 2 * x ** 2 >= max(x, 0.5) and x is not None
'''
FAULTS = (
    "not not x",
    "if not x:",
    "-x - 2",
    "2 / x",
    "x * 2",
    "< max",
    "min(x",
    "or x",
    "x is None",
    "0.45",
    "+x +",
)
KEPT = ("Real = float | int", "-> 'bool | None'", "assert x > 0", '"""Text."""')


def mutants_of(source=SOURCE):
    """Return the mutants of a module, one for each place."""
    return [mutant(source, place, seed=0) for place in mutants(source)]


def test_every_place_gives_a_fault_of_its_own_and_types_and_assertions_stay():
    sources = [made.source for made in mutants_of()]
    plain = ast.unparse(ast.parse(SOURCE)) + "\n"
    assert len({plain, *sources}) == 1 + len(sources)
    assert all(compile(source, "mutant", "exec") for source in sources)
    assert [fault for fault in FAULTS if not any(fault in source for source in sources)] == []
    assert all(part in source for source in sources for part in KEPT)


def test_a_mutant_follows_from_its_seed_and_names_its_place():
    assert mutant(SOURCE, 3, 7) == mutant(SOURCE, 3, 7)
    assert {made.line for made in mutants_of("a = 1\n\nb = a < 2\n")} == {1, 3}
    (less,) = [made for made in mutants_of("b = a < 2\n") if made.after == "a <= 2"]
    assert less.before == "a < 2"


def test_the_lines_of_a_mutant_are_those_of_its_statement_above_its_body():
    made = {mutant.after: mutant for mutant in mutants_of()}
    condition = next(text for text in made if text.startswith("if not x"))
    lines = SOURCE.splitlines()
    assert [lines[line - 1].strip() for line in made[condition].lines] == ["if x:"]
    assert [lines[line - 1].strip() for line in made["not not x"].lines] == ["return not x"]


def test_what_stands_outside_functions_is_known():
    source = "A = 1\n\n\ndef f(x=2):\n    return x + 3\n"
    places = {made.before: made.is_in_function for made in mutants_of(source)}
    assert places == {"1": False, "2": False, "x + 3": True, "3": True}
