"""`tendon completion`: what a shell needs to complete commands, options and their values.

What may stand for a value are words of tendon, and those of the tables and studies that a line names: as typer asks,
each with its meaning, for the command of a context that typer has read as far as it goes.
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
    if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then compopt -o nospace 2>/dev/null; fi
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
_SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}

Shell = Annotated[
    str,
    typer.Argument(
        metavar="bash|zsh|fish", help="which shell", autocompletion=lambda: list(_SCRIPTS)
    ),
]
Line = Annotated[
    str | None, typer.Option(metavar="TEXT", help="complete this line instead; for the script")
]


def completion(context: typer.Context, shell: Shell, line: Line = None) -> None:
    """Print a script that lets bash, zsh or fish complete commands, options, keys and columns.

    bash: eval "$(tendon completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc, after compinit;
    fish: tendon completion fish > ~/.config/fish/completions/tendon.fish
    """
    if shell not in _SCRIPTS:
        from tendon_cli.studies.fields import nearest

        hint = nearest(shell, _SCRIPTS) or "tendon completion bash"
        raise UsageError("there is a script for bash, zsh and fish", where="completion", hint=hint)
    if line is None:
        print_result(_SCRIPTS[shell])
        return
    words, begun, quote = split_line(line)
    items = [
        item for item in candidates(context.find_root().command, words, begun) if item[0] != begun
    ]
    if shell == "bash":  # which splits words at signs of its choice: it gets the rest of each
        text = [_for_bash(word.removeprefix(begun), quote) for word, _ in items]
    else:
        text = [
            f"{word}  {' '.join(meaning.split())}" if meaning else word for word, meaning in items
        ]
    print_result("\n".join(text), unless=not text)


def _for_bash(word: str, quote: str) -> str:
    """A word as bash is to put it into the line, where nothing of it may be run."""
    if quote == "'":
        return word.replace("'", "'\\''")
    return re.sub(r'(["$`\\])' if quote else r"([^\w@%+=:,./-])", r"\\\1", word)


def split_line(line: str) -> tuple[list[str], str, str]:
    """The whole words of a line after the program's, the one that is begun, and the quote that is open in it."""
    for closing in ("", "'", '"'):
        try:
            *words, last = shlex.split(
                f"{line}x{closing}"
            )  # the x makes a word of what is begun, also of nothing
        except ValueError:
            continue
        return words[1:], last[:-1], closing
    return [], "", ""


def candidates(app: Any, words: list[str], begun: str) -> list[tuple[str, str]]:
    """What may stand for the word that is begun, after these words, each with its meaning; nothing for a file.

    `app` is the command of the program, with those below it in `commands`.
    """
    name = next((word for word in words if not word.startswith("-")), None)
    command = app if name is None else app.commands.get(name)
    if command is None:
        return []
    given = words[words.index(name) + 1 :] if name else []
    parameter = next(
        (each for each in command.params if given and given[-1] in each.opts and not each.is_flag),
        None,
    )
    if parameter is not None:
        given.pop()
    elif not begun.startswith("-"):
        parameter = next(
            (each for each in command.params if each.param_type_name == "argument"), None
        )
    context = command.make_context(command.name, given, resilient_parsing=True)
    items = (parameter or command).shell_complete(context, begun)
    return [(item.value, item.help or "") for item in items if item.type == "plain"]


def settings() -> list[Any]:
    """Every key of a study with `=`, and with each of its values if these are few words."""
    from tendon_cli.studies.json_schema import key_words

    return [
        (f"{key}={value}", meaning)
        for key, (meaning, values) in key_words().items()
        for value in ("", *values)
    ]


def keys() -> list[Any]:
    """Every key of a study that holds numbers."""
    from tendon_cli.studies.study import keys as numbers

    return [(path, key.number.quantity.long_name) for path, key in numbers().items()]


def templates() -> list[Any]:
    """The questions that a study can start from."""
    from tendon_cli.studies.starter import TEMPLATES

    return list(TEMPLATES.items())


def tables(ctx: typer.Context) -> list[Any]:
    """The tables of the folder that the line names, else all that there may be."""
    from tendon_cli.cube.source import TABLES

    source = _source(ctx)
    return [
        name for name in TABLES if source is not None and (source / f"{name}.parquet").exists()
    ] or list(TABLES)


def cases(ctx: typer.Context) -> list[Any]:
    """Those of the study that the line names."""
    study = _study(ctx)
    return [case.name for case in study.cases] if study is not None else []


def persons(ctx: typer.Context) -> list[Any]:
    """Those of every survey, and those of the study that the line names."""
    from tendon_cli.studies.people.population import NAMED

    study = _study(ctx)
    names = study.people.population.names if study is not None and study.people is not None else ()
    return [*NAMED, *names[:_MOST_NAMES]]


def columns(ctx: typer.Context, incomplete: str) -> list[Any]:
    """Columns of the table that the line names, else every one that there may be, after those of a list or a sign."""
    before = incomplete[: incomplete.rfind(",") + 1] or ("-" if incomplete.startswith("-") else "")
    return [(before + name, meaning) for name, meaning in (_held(ctx) or _possible()).items()]


def _source(ctx: typer.Context) -> Path | None:
    """The run, table or study that the line names first."""
    first = next(
        (each.name for each in ctx.command.params if each.param_type_name == "argument"), ""
    )
    return ctx.params.get(first or "")


def _study(ctx: typer.Context) -> Any:
    """The study that the line names; None if it cannot be read."""
    source = _source(ctx)
    if source is None or str(source) == "-":
        return None
    from tendon_cli.studies.load import load_study

    try:
        return load_study(source)
    except TendonError:
        return None


def _held(ctx: typer.Context) -> dict[str, str]:
    """Columns of the table that the line names with their meanings, unverified; empty if there is none."""
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
            file = min(file.glob("part-*.parquet")) if file.is_dir() else file
            if not file.is_file():  # a pipe would be waited for
                return {}
            schema = TableFiles((file,)).schema
    except (TendonError, OSError, ValueError):  # an error of Arrow is one of the latter two
        return {}
    return {
        name: (schema.field(name).metadata or {}).get(b"long_name", b"").decode()
        for name in schema.names
    }


def _possible() -> dict[str, str]:
    """Every column that a table of tendon may have, with its meaning."""
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.studies.study import keys as numbers

    results = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    return results | {key.column: key.number.quantity.long_name for key in numbers().values()}
