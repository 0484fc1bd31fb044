"""The tool against an engine nobody here wrote; `make verify` (see docs/verification.md)."""
