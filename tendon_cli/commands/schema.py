"""`tendon schema`: what editors need of a study file."""

from tendon_cli.terminal import print_result


def schema() -> None:
    """Print the JSON Schema of the study file, for editors."""
    from tendon_cli.studies.schema import schema_text

    print_result(schema_text())
