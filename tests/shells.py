"""Lines as a shell hands them to a program to complete."""

import re

_WORDS = re.compile(r"""=|(?:\\.|'[^']*'?|"[^"]*"?|[^\s=\\'"])+""")


def asked_by_bash(line):
    """Return the variables with which bash asks what completes the end of a line."""
    words = _WORDS.findall(line)
    if line.endswith(" ") and not line.endswith("\\ ") and not re.search(r"""['"]""", words[-1]):
        words.append("")
    return {
        "_TENDON_COMPLETE": "complete_bash",
        "COMP_WORDS": "\n".join(words),
        "COMP_CWORD": str(len(words) - 1),
    }
