"""Imports run one way, printing happens in one place, and no two classes share a name."""

import ast
import functools
import subprocess
import sys
from pathlib import Path

import pytest

import tendon_cli

PACKAGE = Path(tendon_cli.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
GROUND = {
    "errors",
    "files",
    "quantities",
    "readers",
    "say",
    "units",
    "verbs",
    "version",
}
ROOMS = ("figures", "fits", "engine")
BELOW_THE_ROOMS = {"studies", "tables", "model", *GROUND}
THE_FACE = ""

# What each room, and each file at the root, may import of the package besides itself.
MAY_IMPORT = {
    "version": set(),
    "errors": set(),
    "terminal": {"errors"},
    "files": {"errors", "units"},
    "verbs": {"errors", "units"},
    "quantities": {"units"},
    "readers": {"errors", "files", "units"},
    "units": set(),
    "model": {"quantities", "units", "errors"},
    "say": {"errors", "quantities", "units", "verbs"},
    "tables": GROUND,
    "studies": {"model", *GROUND},
    "cube": {"engine", *BELOW_THE_ROOMS},
    "figures": {"cube", "say", *BELOW_THE_ROOMS},
    "fits": BELOW_THE_ROOMS,
    "kernel": {"model", "quantities"},
    "engine": {"kernel", *BELOW_THE_ROOMS},
    "proof": {"engine", "kernel", *BELOW_THE_ROOMS},
    "answers": {"proof", "engine", "kernel", "figures", *BELOW_THE_ROOMS},
    "exports": {"answers", "engine", *BELOW_THE_ROOMS},
    "checks": {"answers", "cube", *ROOMS, *BELOW_THE_ROOMS},
    "reports": {"cube", *ROOMS, *BELOW_THE_ROOMS},
    "state_page": {"figures", "engine", *BELOW_THE_ROOMS},
}
MAY_IMPORT["face"] = {name for name in MAY_IMPORT if name != "terminal"}
MAY_IMPORT[THE_FACE] = set(MAY_IMPORT) - {"terminal"}
MAY_IMPORT["commands"] = set(MAY_IMPORT) - {THE_FACE}
MAY_IMPORT["__main__"] = {"commands"}
MOST_FLOORS = 11
"""Rooms and files at the root that lie above one another, at most."""


def name_of(path):
    """The dotted name of a file within the package."""
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def room_of(name):
    return name.partition(".")[0]


@functools.cache
def nodes(path):
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def imported(path):
    """Yield the full dotted name of every module that a file imports, inside functions, too."""
    here = ["tendon_cli", *filter(None, name_of(path).split("."))]
    package = here if path.name == "__init__.py" else here[:-1]
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            source = ".".join([*base, *([node.module] if node.module else [])])
            yield from (_module(f"{source}.{alias.name}", source) for alias in node.names)


def _module(whole, source):
    """Return the module that `from a import b` imports: a.b if that is a module, else a."""
    path = PACKAGE.parent.joinpath(*whole.split("."))
    return whole if path.is_dir() or path.with_suffix(".py").is_file() else source


def ours(path):
    """Return the modules of the package that a file imports."""
    names = {name for name in imported(path) if name.partition(".")[0] == "tendon_cli"}
    return sorted(name.removeprefix("tendon_cli").removeprefix(".") for name in names)


def files_of(*rooms):
    return [path for path in FILES if room_of(name_of(path)) in rooms]


def wrong(files, imports_of):
    """Return the imports that a file should not have, by its name."""
    imports = {name_of(path): sorted(imports_of(path)) for path in files}
    return {name: found for name, found in imports.items() if found}


def test_every_room_and_every_file_at_the_root_has_its_place():
    assert {room_of(name_of(path)) for path in FILES} <= set(MAY_IMPORT)


def test_a_room_imports_only_what_lies_below_it():
    def above(path):
        room = room_of(name_of(path))
        return [name for name in ours(path) if room_of(name) not in MAY_IMPORT[room] | {room}]

    assert wrong(FILES, above) == {}


def test_the_model_knows_numpy_and_the_standard_library_only():
    known = {"numpy", "tendon_cli", *sys.stdlib_module_names}

    def unknown(path):
        return {name.partition(".")[0] for name in imported(path)} - known

    assert wrong(files_of("model"), unknown) == {}


def test_figures_take_only_the_kinematics_of_the_model():
    def model(path):
        modules = [name for name in ours(path) if room_of(name) == "model"]
        return [name for name in modules if name != "model.kinematics"]

    assert wrong(files_of("figures"), model) == {}


OF_A_TEXT = {"say", "studies", "quantities"}
OF_RECORDS = {"verbs.answer_record", "verbs.typed_record"}


def test_the_text_of_an_answer_knows_its_record_and_no_question():
    texts = {"answers.text", "answers.phrases", "answers.record_tables"}
    texts |= {name_of(path) for path in FILES if name_of(path).startswith("answers.text_")}
    files = [path for path in FILES if name_of(path) in texts]

    def beyond_the_record(path):
        known = {"model.kinematics", *OF_RECORDS, *texts}
        return [name for name in ours(path) if room_of(name) not in OF_A_TEXT and name not in known]

    assert len(files) == len(texts) > 2
    assert wrong(files, beyond_the_record) == {}


@pytest.mark.parametrize("room", ROOMS)
def test_rooms_of_one_level_do_not_know_each_other(room):
    others = {*ROOMS} - {room}

    def neighbours(path):
        return {room_of(name) for name in ours(path)} & others

    assert wrong(files_of(room), neighbours) == {}


def test_the_two_fits_share_their_ground_and_not_each_other():
    def beyond_the_ground(path):
        own = name_of(path).split(".")[1:2]
        fits = {"fits.friction", "fits.suit"} - {f"fits.{room}" for room in own}
        return [name for name in ours(path) if ".".join(name.split(".")[:2]) in fits]

    assert wrong(files_of("fits"), beyond_the_ground) == {}


def test_nobody_imports_the_command_line():
    files = [path for path in FILES if room_of(name_of(path)) not in ("__main__", "commands")]

    def commands(path):
        return [name for name in ours(path) if room_of(name) == "commands"]

    assert wrong(files, commands) == {}


def test_rooms_lie_on_few_floors():
    below = {}
    for path in FILES:
        room = room_of(name_of(path))
        below.setdefault(room, set()).update({room_of(name) for name in ours(path)} - {room})

    @functools.cache
    def floor(room):
        return 1 + max(map(floor, below[room]), default=0)

    assert max(map(floor, below)) <= MOST_FLOORS


def test_no_file_imports_itself_over_others():
    imports = {name_of(path): set(ours(path)) for path in FILES}

    def reached_from(name):
        reached = set()
        new = set(imports[name])
        while new:
            reached |= new
            new = {further for module in new for further in imports.get(module, ())} - reached
        return reached

    assert [name for name in imports if name in reached_from(name)] == []


# --- Printing -------------------------------------------------------------------------------------


OUTLETS = ("stdout", "stderr", "__stdout__", "__stderr__", "echo", "secho")


def prints(path):
    """Yield the lines that print, or touch a standard stream."""
    for node in nodes(path):
        is_print = isinstance(node, ast.Name) and node.id == "print"
        is_stream = isinstance(node, ast.Attribute) and node.attr in OUTLETS
        if is_print or is_stream:
            yield node.lineno


def test_only_the_terminal_prints():
    assert wrong([path for path in FILES if name_of(path) != "terminal"], prints) == {}


def test_the_terminal_imports_nothing_but_errors():
    assert ours(PACKAGE / "terminal.py") == ["errors"]


# --- Starting soon --------------------------------------------------------------------------------

HEAVY = ("pandas", "scipy", "matplotlib", "pyarrow", "joblib", "ruamel", "rich", "distributed")


def loaded_by(code):
    script = f"import sys\n{code}\nprint(*[name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout.split()


READING = "from tendon_cli.studies.load import load_study\nload_study('study.toml')"


@pytest.mark.parametrize("code", [READING, "import tendon_cli.model.actuator"])
def test_reading_a_study_and_importing_the_model_load_no_heavy_library(workplace, code):
    (workplace / "study.toml").touch()
    assert loaded_by(code) == []


@pytest.mark.parametrize("module", ["figures.draw", "checks.check", "reports.report", "cube.rows"])
def test_what_draws_nothing_loads_no_matplotlib(module):
    assert not {"matplotlib", "scipy", "pandas"}.intersection(
        loaded_by(f"import tendon_cli.{module}")
    )


# --- Names ----------------------------------------------------------------------------------------


def test_no_two_classes_of_the_package_share_a_name():
    names = [node.name for path in FILES for node in nodes(path) if isinstance(node, ast.ClassDef)]
    assert sorted({name for name in names if names.count(name) > 1}) == []


# --- Size of objects ------------------------------------------------------------------------------

MOST_MEMBERS = 35
"""Most members of a class that has methods; plain data may have more."""


def members(node):
    """Return the names of the fields, attributes, properties and methods of a class.

    Attributes that a method gives itself count, too. Names between double underscores do not.
    """
    names = set()
    for part in node.body:
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef):
            names.add(part.name)
        elif isinstance(part, ast.AnnAssign):
            names.add(part.target.id)
        elif isinstance(part, ast.Assign):
            names.update(target.id for target in part.targets if isinstance(target, ast.Name))
    for part in ast.walk(node):
        is_set = isinstance(part, ast.Attribute) and isinstance(part.ctx, ast.Store)
        if is_set and isinstance(part.value, ast.Name) and part.value.id == "self":
            names.add(part.attr)
    return {name for name in names if not (name.startswith("__") and name.endswith("__"))}


def has_methods(node):
    """Return True if a class has a method that is no property and makes no object of it."""
    kinds = ("property", "cached_property", "classmethod", "staticmethod")
    for part in node.body:
        if isinstance(part, ast.FunctionDef) and not part.name.startswith("__"):
            decorators = {getattr(one, "id", "") for one in part.decorator_list}
            if not decorators & {*kinds}:
                return True
    return False


def test_no_object_with_methods_has_more_members_than_can_be_said_in_a_sentence():
    classes = [node for path in FILES for node in nodes(path) if isinstance(node, ast.ClassDef)]
    large = {node.name for node in classes if len(members(node)) > MOST_MEMBERS}
    with_methods = {node.name for node in classes if has_methods(node)}
    assert large & with_methods == set()
