"""Studies that tests say in SI numbers: a study takes no angle without its unit."""

ANGLES = (
    "bend_angle",
    "upper_arm_angle",
    "contact_from",
    "elbow_angle",
    "rest_angle",
    "angle",
)


def with_units(content, key=""):
    """The same content, each bare angle with its unit; keys may be dotted."""
    if isinstance(content, dict):
        return {
            name: with_units(
                value, key if name in ("from", "to", "mean", "std") else name.rpartition(".")[2]
            )
            for name, value in content.items()
        }
    if isinstance(content, (list, tuple)):
        return [with_units(item, key) for item in content]
    is_bare = key in ANGLES and isinstance(content, (int, float)) and not isinstance(content, bool)
    return f"{float(content)!r} rad" if is_bare else content
