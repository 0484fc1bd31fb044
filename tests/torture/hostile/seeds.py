"""The files that breeding starts from, and the words that they are made of."""

from .readings import CSV_TOKENS, good_readings
from .studies import STUDY_TOKENS, good_studies
from .tables import PARQUET_TOKENS, PLAIN, WITH_CASES, good_tables

TOKENS = {"toml": STUDY_TOKENS, "yaml": STUDY_TOKENS, "csv": CSV_TOKENS, "parquet": PARQUET_TOKENS}


def seeds(kind):
    """Files of a kind to start from."""
    if kind == "csv":
        return good_readings()
    if kind == "parquet":
        return good_tables(PLAIN) + good_tables(WITH_CASES)
    return [content for suffix, content in good_studies() if suffix == f".{kind}"]


def dictionary(kind):
    """The words of a kind, as libFuzzer reads them."""
    from tendon_cli.studies.study import keys
    from tendon_cli.units import UNITS

    tokens = TOKENS[kind]
    if kind in ("toml", "yaml"):
        parts = {part for key in keys() for part in key.split(".")} | set(keys()) | set(UNITS)
        tokens = [*tokens, *(part.encode() for part in sorted(parts))]
    lines = ('"' + "".join(f"\\x{byte:02x}" for byte in token) + '"' for token in tokens if len(token) <= 64)
    return "\n".join(lines) + "\n"
