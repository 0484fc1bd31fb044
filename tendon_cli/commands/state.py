"""`tendon state`: one state, for a check by hand."""

import tendon_cli as tendon
from tendon_cli.commands import options
from tendon_cli.terminal import as_json_text, print_result


def state(
    study: options.StudyFile,
    settings: options.Settings = None,
    case: options.Case = None,
    person: options.Person = None,
    as_json: options.AsJson = False,
) -> None:
    """Work one state out, with the equations' numbers, for a check by hand."""
    page = tendon.state(tendon.load_study(study, settings or ()), case, person)
    print_result(as_json_text(page.record()) if as_json else page.text())
