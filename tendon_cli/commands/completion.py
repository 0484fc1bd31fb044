"""`tendon completion`: scripts and candidates with which a shell completes commands and values.

Candidates for a value are words of tendon, and words of the tables and studies that the line names.
Typer calls the functions that return them with the context of the command, parsed as far as the
line goes. A candidate is a word, or a word with its meaning.
"""

import re
import shlex
from pathlib import Path
from typing import Annotated, Any

import typer

from tendon_cli.errors import TendonError, UsageError
from tendon_cli.terminal import print_result

_BASH = """\
_tendon() {
    local rest
    COMPREPLY=()
    while IFS= read -r rest; do COMPREPLY+=("$2$rest"); done < <(
        "$1" completion bash --line "${COMP_LINE:0:COMP_POINT}" 2>/dev/null
    )
    if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then
        compopt -o nospace 2>/dev/null
    fi
}
complete -o default -F _tendon tendon"""

_ZSH = """\
#compdef tendon
_tendon() {
    local entry word line="${(j: :)words[1,CURRENT-1]} $QIPREFIX$PREFIX"
    local -a open open_shown closed closed_shown
    for entry in ${(f)"$(${words[1]} completion zsh --line "$line" 2>/dev/null)"}; do
        word=${entry%%  *}
        if [[ $word == *= ]]; then
            open+=("$word") open_shown+=("${entry/  /  -- }")
        else
            closed+=("$word") closed_shown+=("${entry/  /  -- }")
        fi
    done
    if (( $#open + $#closed == 0 )); then _files; return; fi
    (( $#open )) && compadd -S '' -l -d open_shown -a open
    (( $#closed )) && compadd -l -d closed_shown -a closed
    return 0
}
if [ "$funcstack[1]" = _tendon ]; then _tendon "$@"; else compdef _tendon tendon; fi"""

_FISH = """\
function __tendon_complete
    set -l words (tendon completion fish --line (commandline -cp | string collect) 2>/dev/null)
    if test (count $words) -gt 0
        string replace '  ' \\t -- $words
    else
        __fish_complete_path (commandline -ct)
    end
end
complete -c tendon -f -a '(__tendon_complete)'"""

_MOST_NAMES = 1000
"""Largest number of persons of a study that are offered."""
_SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}

ShellArgument = Annotated[
    str,
    typer.Argument(
        metavar="bash|zsh|fish", help="which shell", autocompletion=lambda: list(_SCRIPTS)
    ),
]
LineOption = Annotated[
    str | None,
    typer.Option(metavar="TEXT", help="for the script: print the completions of this line instead"),
]


def completion(context: typer.Context, shell: ShellArgument, line: LineOption = None) -> None:
    """Print a script that lets bash, zsh or fish complete commands, options, keys and columns.

    bash: eval "$(tendon completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc, after compinit;
    fish: tendon completion fish > ~/.config/fish/completions/tendon.fish
    """
    if shell not in _SCRIPTS:
        from tendon_cli.studies.fields import hint_at_nearest

        hint = hint_at_nearest(shell, _SCRIPTS) or "tendon completion bash"
        problem = f'there is no script for "{shell}", expected bash, zsh or fish'
        raise UsageError(problem, where="completion", hint=hint)
    if line is None:
        print_result(_SCRIPTS[shell])
        return
    words, begun, quote = split_line(line)
    found = candidates(context.find_root().command, words, begun)
    items = [(word, meaning) for word, meaning in found if word != begun]
    if shell == "bash":  # splits words at signs such as "=", so it needs the rest of each
        lines = [_for_bash(word.removeprefix(begun), quote) for word, _ in items]
    else:
        lines = [_with_meaning(word, meaning) for word, meaning in items]
    print_result("\n".join(lines), unless=not lines)


def _with_meaning(word: str, meaning: str) -> str:
    """Return a word with its meaning after two spaces, on one line, as zsh and fish read it."""
    return f"{word}  {' '.join(meaning.split())}" if meaning else word


def _for_bash(word: str, quote: str) -> str:
    """Return a word escaped for bash, so that the line runs no part of it."""
    if quote == "'":
        return word.replace("'", "'\\''")
    if quote == '"':
        return re.sub(r'(["$`\\])', r"\\\1", word)
    return re.sub(r"([^\w@%+=:,./-])", r"\\\1", word)


def split_line(line: str) -> tuple[list[str], str, str]:
    """Split a line that is being typed.

    Returns:
        The whole words after the name of the program, the word that is begun, and the quote that
        is open in it.
    """
    for quote in ("", "'", '"'):
        try:
            # The x makes a word of what is begun, also of nothing.
            *words, last = shlex.split(f"{line}x{quote}")
        except ValueError:
            continue
        return words[1:], last[:-1], quote
    return [], "", ""


def candidates(app: Any, words: list[str], begun: str) -> list[tuple[str, str]]:
    """Return the completions of the word that is begun, each with its meaning.

    Args:
        app: Command of the program, with its subcommands in `commands`.
        words: Words of the line before it.
        begun: Beginning of the word, which may be empty.

    Returns:
        Words and meanings; none if a file is to be named.
    """
    name = next((word for word in words if not word.startswith("-")), None)
    command = app if name is None else app.commands.get(name)
    if command is None:
        return []
    given = words[words.index(name) + 1 :] if name else []
    parameter = _option_awaiting_value(command, given)
    if parameter is not None:
        given.pop()
    elif not begun.startswith("-"):
        parameter = _first_argument(command)
    context = command.make_context(command.name, given, resilient_parsing=True)
    items = (parameter or command).shell_complete(context, begun)
    return [(item.value, item.help or "") for item in items if item.type == "plain"]


def _option_awaiting_value(command: Any, given: list[str]) -> Any:
    """Return the option whose value comes after the last word given; None if there is none."""
    if not given:
        return None
    for parameter in command.params:
        if given[-1] in parameter.opts and not parameter.is_flag:
            return parameter
    return None


def _first_argument(command: Any) -> Any:
    """Return the first argument of a command; None if it has none."""
    for parameter in command.params:
        if parameter.param_type_name == "argument":
            return parameter
    return None


def settings() -> list[Any]:
    """Return all keys of a study with `=`, and with each of their values if these are few words."""
    from tendon_cli.studies.json_schema import key_words

    return [
        (f"{key}={value}", meaning)
        for key, (meaning, values) in key_words().items()
        for value in ("", *values)
    ]


def keys() -> list[Any]:
    """Return all keys of a study that hold numbers."""
    from tendon_cli.studies.study import keys as number_keys

    return [(path, key.quantity.long_name) for path, key in number_keys().items()]


def templates() -> list[Any]:
    """Return the questions that a study can start from."""
    from tendon_cli.studies.starter import TEMPLATES

    return list(TEMPLATES.items())


def tables(ctx: typer.Context) -> list[Any]:
    """Return the tables of the folder or the study that the line names, or else of every kind."""
    from tendon_cli.registry import table_kinds

    source = _source(ctx)
    if source is not None and source.suffix.lower() in (".toml", ".yaml", ".yml"):
        study = _study(ctx)
        return [table.key for table in study.row_tables] if study is not None else []
    if source is not None:
        found = [name for name in table_kinds() if (source / f"{name}.parquet").exists()]
        if found:
            return found
    return list(table_kinds())


def cases(ctx: typer.Context) -> list[Any]:
    """Return the cases of the study that the line names."""
    study = _study(ctx)
    return [case.name for case in study.cases] if study is not None else []


def rows(ctx: typer.Context) -> list[Any]:
    """Return the rows of the tables of the study that the line names, as TABLE=NAME."""
    study = _study(ctx)
    tables = study.row_tables if study is not None else ()
    return [f"{table.key}={name}" for table in tables for name in table.names[:_MOST_NAMES]]


def persons(ctx: typer.Context) -> list[Any]:
    """Return the standard persons, and those of the study that the line names."""
    from tendon_cli.studies.people.population import STANDARD_PERSONS

    study = _study(ctx)
    if study is None or study.people is None:
        return list(STANDARD_PERSONS)
    return [*STANDARD_PERSONS, *study.people.population.names[:_MOST_NAMES]]


def columns(ctx: typer.Context, incomplete: str) -> list[Any]:
    """Return the columns of the table that the line names, or else all columns of tendon.

    Each has the text before it on the line: the other columns of a list, or the sign to sort by.
    """
    before = incomplete[: incomplete.rfind(",") + 1]
    if not before and incomplete.startswith("-"):
        before = "-"
    names = _columns_of_table(ctx) or _all_columns()
    return [(before + name, meaning) for name, meaning in names.items()]


def _source(ctx: typer.Context) -> Path | None:
    """Return the run, table or study that the line names first."""
    argument = _first_argument(ctx.command)
    return None if argument is None else ctx.params.get(argument.name)


def _study(ctx: typer.Context) -> Any:
    """Return the study that the line names; None if it cannot be read."""
    source = _source(ctx)
    if source is None or str(source) == "-":
        return None
    from tendon_cli.studies.load import load_study

    try:
        return load_study(source)
    except TendonError:
        return None


def _columns_of_table(ctx: typer.Context) -> dict[str, str]:
    """Return the columns of the table that the line names with their meanings, unverified.

    There are none if the line names no table.
    """
    source = _source(ctx)
    if source is None:
        return {}
    from tendon_cli.cube.source import file_of, table_in
    from tendon_cli.tables.read import TableFiles

    try:
        if source.suffix.lower() == ".csv":
            schema = table_in(source).schema
        else:
            file = file_of(source, ctx.params.get("table"))
            if file.is_dir():
                file = min(file.glob("part-*.parquet"))
            if not file.is_file():  # opening a pipe would wait
                return {}
            schema = TableFiles((file,)).schema
    except (TendonError, OSError, ValueError):  # errors of Arrow are among the latter two
        return {}
    meanings = {}
    for name in schema.names:
        metadata = schema.field(name).metadata or {}
        meanings[name] = metadata.get(b"long_name", b"").decode()
    return meanings


def _all_columns() -> dict[str, str]:
    """Return all columns that a table of tendon may have, with their meanings."""
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.studies.study import keys as number_keys

    results = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    numbers = {key.column: key.quantity.long_name for key in number_keys().values()}
    return results | numbers
