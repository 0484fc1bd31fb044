"""`--set` that sets nothing."""

from tendon_cli.errors import StudyError, UsageError

from .row import Malformed


def setting(label, text, *says, kind=UsageError, study="", **more):
    return Malformed(f"set {label}", study, says, kind=kind, settings=(text,), **more)


def wrong_value(label, text, *says, **more):
    return setting(label, text, *says, kind=StudyError, **more)


SETTINGS = (
    setting("without equals sign", "arm.b1", "arm.b1", "KEY=VALUE"),
    setting("without a key", "=3", "KEY=VALUE"),
    setting("a key of 100000 parts", ".".join("a" * 100_000) + "=3", "KEY=VALUE"),
    setting("an open list", "load.mass=[1, 2", "load.mass", "not TOML"),
    setting("words in a list", "load.mass=[3 kg]", "load.mass", "not TOML"),
    setting("a number below a number", "arm.b1.x=3", "arm.b1.x", "not a table", study="arm.b1 = 0.1\n"),
    setting("a key with an escape", "\x1b[31m={", "set"),
    setting("a line after the value", "load.mass=[1, 2]\nx = 3", "load.mass"),
    wrong_value("an unknown table", "amr.b1=3 mm", "amr", "unknown key", '"arm"'),
    wrong_value("an interval that goes down", "load.mass={from=2, to=1}", "load.mass", "go up"),
    wrong_value("a name with a slash", "name=../x", "name", "letters, digits"),
    wrong_value(
        "an axis of a case", "load.mass=[1, 2]", "cases.0.load.mass", study="[[cases]]\nname = 'a'\nload.mass = 1\n"
    ),
)
