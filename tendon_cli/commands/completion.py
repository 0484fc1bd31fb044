"""`tendon completion`: what a shell needs to complete commands, options, keys, values and columns."""

import re
import shlex
from typing import Annotated, Any

import typer

from tendon_cli.commands.own_words import KNOWN, Given, Words
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


def completion(context: typer.Context, shell: Shell, line: Line = None, breaks: Breaks = "=:") -> None:
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
    found = [item for item in candidates(context.find_root().command, words, begun) if item[0] != begun]
    if shell == "bash":
        ends = [begun.rfind(mark) + 1 for mark in "=:" if mark in breaks and not quote]
        text = [_for_bash(word[max(ends, default=0) :], quote) for word, _ in found]
    else:
        text = [f"{word}  {' '.join(meaning.split())}" if meaning else word for word, meaning in found]
    if text:
        print_result("\n".join(text))


def _for_bash(word: str, quote: str) -> str:
    """A word as bash is to put it into the line, where nothing of it may be run."""
    if quote == "'":
        return word.replace("'", "'\\''")
    return re.sub(r'(["$`\\])' if quote else r"([^\w@%+=:,./-])", r"\\\1", word)


def split_line(line: str) -> tuple[list[str], str, str]:
    """The whole words of a line after the program's, the one that is begun, and the quote that is open in it."""
    for closing in ("", "'", '"'):
        try:
            *words, last = shlex.split(f"{line}x{closing}")  # the x makes a word of what is begun, also of nothing
        except ValueError:
            continue
        return words[1:], last[:-1], closing
    return [], "", ""


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
    line = _given(words[words.index(names[0]) + 1 :], options) if names else Given()
    if words and (asked := options.get(words[-1])) is not None and not asked.is_flag:
        return _fitting(begun, _values(asked, line.asking(begun)))
    if begun.startswith("--") and equals:
        found = _fitting(value, _values(options.get(name), line.asking(value)))
        return [(f"{name}={word}", text) for word, text in found]
    if begun.startswith("-") or not (command is None or _arguments(command)):
        every = [option for option in (command or app).params if option.opts[0].startswith("-")]
        described = [(name, option.help or "") for option in every for name in (*option.opts, *option.secondary_opts)]
        described.append(("--help", "show this message"))
        return _fitting(begun, [item for item in described if item[0].startswith("--")])
    if command is None:
        return _fitting(begun, [(name, known.get_short_help_str(80)) for name, known in app.commands.items()])
    return _fitting(begun, _values(_arguments(command)[0], line))


def _given(words: list[str], options: dict[str, Any]) -> Given:
    """What a command has been given so far: its first argument, and the values of its options."""
    arguments, values, waiting = [], {}, ""
    for word in words:
        name, equals, value = word.partition("=")
        if waiting:
            values[waiting], waiting = word, ""
        elif not word.startswith("-"):
            arguments.append(word)
        elif name in options and equals:
            values[options[name].name] = value
        elif name in options and not options[name].is_flag:
            waiting = options[name].name
    return Given(arguments[0] if arguments else "", values)


def _arguments(command: Any) -> list[Any]:
    return [parameter for parameter in command.params if not parameter.opts[0].startswith("-")]


def _fitting(begun: str, words: Words) -> list[tuple[str, str]]:
    """The words that go on as the begun one; in a list of names, and after the sign of a sort, its last name counts."""
    kept = max(begun.rfind(","), 0 if begun.startswith("-") and not begun.startswith("--") and len(begun) > 1 else -1)
    before, rest = begun[: kept + 1], begun[kept + 1 :]
    found = [(word, meaning) for word, meaning in words if word.startswith(begun)]
    return found or [(before + word, meaning) for word, meaning in words if word.startswith(rest)]


def _values(parameter: Any, line: Given) -> list[tuple[str, str]]:
    """What an option or an argument may be, where that is one of a few."""
    if parameter is None:
        return []
    if parameter.name in KNOWN:
        return list(KNOWN[parameter.name](line))
    choices = str(parameter.metavar or "").split("|")
    return [(choice, "") for choice in choices] if len(choices) > 1 else []
