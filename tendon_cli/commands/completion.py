"""`tendon completion`: what a shell needs to complete commands, options, keys, values and columns."""

import re
import shlex
from typing import Annotated, Any

import typer

from tendon_cli.errors import UsageError
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

_SCRIPTS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}

Shell = Annotated[
    str, typer.Argument(metavar="bash|zsh|fish", help="which shell", autocompletion=lambda: list(_SCRIPTS))
]
Line = Annotated[str | None, typer.Option(metavar="TEXT", help="complete this line instead; for the script")]


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
    items = [item for item in candidates(context.find_root().command, words, begun) if item[0] != begun]
    if shell == "bash":  # which splits words at signs of its choice: it gets the rest of each
        text = [_for_bash(word.removeprefix(begun), quote) for word, _ in items]
    else:
        text = [f"{word}  {' '.join(meaning.split())}" if meaning else word for word, meaning in items]
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
            *words, last = shlex.split(f"{line}x{closing}")  # the x makes a word of what is begun, also of nothing
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
    parameter = next((each for each in command.params if given and given[-1] in each.opts and not each.is_flag), None)
    if parameter is not None:
        given.pop()
    elif not begun.startswith("-"):
        parameter = next((each for each in command.params if each.param_type_name == "argument"), None)
    context = command.make_context(command.name, given, resilient_parsing=True)
    items = (parameter or command).shell_complete(context, begun)
    return [(item.value, item.help or "") for item in items if item.type == "plain"]
