"""`python -m tendon_cli` is `tendon`."""

from tendon_cli.cli import main

main()
