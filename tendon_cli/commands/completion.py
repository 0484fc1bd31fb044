"""`tendon completion`: what a shell needs to complete commands, options, keys, values and columns."""

import shlex
from collections.abc import Callable, Iterable
from typing import Annotated, Any

import typer

from tendon_cli.errors import UsageError
from tendon_cli.terminal import print_result

_BASH = """\
_tendon() {
    local word breaks=$COMP_WORDBREAKS
    COMPREPLY=()
    while IFS= read -r word; do COMPREPLY+=("$word"); done < <(
        "$1" completion bash --line "${COMP_LINE:0:COMP_POINT}" --breaks "$breaks" 2>/dev/null
    )
    if [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]]; then compopt -o nospace 2>/dev/null; fi
}
complete -o default -F _tendon tendon"""

_ZSH = """\
#compdef tendon
_tendon() {
    local entry word
    local -a open open_shown closed closed_shown
    for entry in ${(f)"$(${words[1]} completion zsh --line "${(j: :)words[1,CURRENT-1]} $PREFIX" 2>/dev/null)"}; do
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
    set -l found (tendon completion fish --line (commandline -cp | string collect) 2>/dev/null)
    if test (count $found) -gt 0
        string replace '  ' \\t -- $found
    else
        __fish_complete_path (commandline -ct)
    end
end
complete -c tendon -f -a '(__tendon_complete)'"""

_SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}

Shell = Annotated[str, typer.Argument(metavar="bash|zsh|fish", help="which shell")]
Line = Annotated[str | None, typer.Option(metavar="TEXT", help="complete this line instead, as the script asks")]
Breaks = Annotated[str, typer.Option(metavar="TEXT", help="with --line: where bash takes a word apart")]

Words = Iterable[tuple[str, str]]
"""Words that may stand there, each with what it means."""


def completion(context: typer.Context, shell: Shell, line: Line = None, breaks: Breaks = "=:") -> None:
    """Print a script by which bash, zsh or fish completes commands, options, keys and columns.

    bash: eval "$(tendon completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc, after compinit;
    fish: tendon completion fish > ~/.config/fish/completions/tendon.fish
    """
    if shell not in _SCRIPTS:
        raise UsageError("there is a script for bash, zsh and fish", where="completion", hint="tendon completion bash")
    if line is None:
        print_result(_SCRIPTS[shell])
        return
    words, begun, is_quoted = split_line(line)
    found = [item for item in candidates(context.find_root().command, words, begun) if item[0] != begun]
    if shell == "bash":
        ends = [begun.rfind(mark) + 1 for mark in "=:" if mark in breaks and not is_quoted]
        text = [word[max(ends, default=0) :] for word, _ in found]
    else:
        text = [f"{word}  {' '.join(meaning.split())}" if meaning else word for word, meaning in found]
    if text:
        print_result("\n".join(text))


def split_line(line: str) -> tuple[list[str], str, bool]:
    """The whole words of a line after the program's, the one that is begun, and whether that is in an open quote."""
    for closing in ("", "'", '"'):
        try:
            *words, last = shlex.split(f"{line}x{closing}")  # the x makes a word of what is begun, also of nothing
        except ValueError:
            continue
        return words[1:], last[:-1], bool(closing)
    return [], "", False


def candidates(app: Any, words: list[str], begun: str) -> list[tuple[str, str]]:
    """What may stand for the word that is begun, after these words; nothing where a file is to stand.

    `app` is the command of the program, with those below it in `commands`.
    """
    names = [word for word in words if not word.startswith("-")]
    command = app.commands.get(names[0]) if names else None
    if names and command is None:
        return []
    options = {name: option for option in (command or app).params for name in option.opts if name.startswith("-")}
    name, equals, value = begun.partition("=")
    if words and (asked := options.get(words[-1])) is not None and not asked.is_flag:
        return _fitting(begun, _values(asked))
    if begun.startswith("--") and equals:
        return [(f"{name}={word}", text) for word, text in _fitting(value, _values(options.get(name)))]
    if begun.startswith("-") or not (command is None or _arguments(command)):
        every = [option for option in (command or app).params if option.opts[0].startswith("-")]
        described = [(name, option.help or "") for option in every for name in (*option.opts, *option.secondary_opts)]
        described.append(("--help", "show this message"))
        return _fitting(begun, [item for item in described if item[0].startswith("--")])
    if command is None:
        return _fitting(begun, [(name, known.get_short_help_str(80)) for name, known in app.commands.items()])
    return _fitting(begun, _values(_arguments(command)[0]))


def _arguments(command: Any) -> list[Any]:
    return [parameter for parameter in command.params if not parameter.opts[0].startswith("-")]


def _fitting(begun: str, words: Words) -> list[tuple[str, str]]:
    """The words that go on as the begun one; in a list of names, and after the sign of a sort, its last name counts."""
    kept = max(begun.rfind(","), 0 if begun.startswith("-") and not begun.startswith("--") and len(begun) > 1 else -1)
    before, rest = begun[: kept + 1], begun[kept + 1 :]
    found = [(word, meaning) for word, meaning in words if word.startswith(begun)]
    return found or [(before + word, meaning) for word, meaning in words if word.startswith(rest)]


def _values(parameter: Any) -> list[tuple[str, str]]:
    """What an option or an argument may be, where that is one of a few."""
    if parameter is None:
        return []
    if parameter.name in _KNOWN:
        return list(_KNOWN[parameter.name]())
    choices = str(parameter.metavar or "").split("|")
    return [(choice, "") for choice in choices] if len(choices) > 1 else []


def _settings() -> Words:
    """Every key of a study with `=`, and with each of its values where these are few words."""
    from tendon_cli.study.schema import key_words

    for key, (meaning, values) in key_words().items():
        yield f"{key}=", meaning
        yield from ((f"{key}={value}", meaning) for value in values)


def _keys() -> Words:
    from tendon_cli.study.study import keys

    return [(path, key.number.quantity.long_name) for path, key in keys().items()]


def _columns() -> Words:
    """Every column that a table of tendon may have: results, and the numbers of a study."""
    from tendon_cli.quantities import OF_CYCLES, OF_DESIGNS, OF_STATES, QUANTITIES
    from tendon_cli.study.study import keys

    found = {name: QUANTITIES[name].long_name for name in (*OF_DESIGNS, *OF_STATES, *OF_CYCLES)}
    return (found | {key.column: key.number.quantity.long_name for key in keys().values()}).items()


def _units() -> Words:
    from tendon_cli.units import UNITS

    return [(unit.symbol, unit.dimension) for unit in UNITS.values()]


def _templates() -> Words:
    from tendon_cli.study.starter import TEMPLATES

    return TEMPLATES.items()


def _tables() -> Words:
    return [("designs", ""), ("states", ""), ("choices", ""), ("conditions", "")]


_KNOWN: dict[str, Callable[[], Words]] = {
    "settings": _settings,
    "apart": _keys,
    **dict.fromkeys(("columns", "quantity", "x", "colour", "panels", "where", "sort"), _columns),
    "template": _templates,
    "unit": _units,
    "table": _tables,
    "person": lambda: [("mean-man", ""), ("mean-woman", "")],
    "size": lambda: [("column", "85 mm"), ("page", "175 mm")],
}
"""By the name of a parameter, the words that complete it."""
