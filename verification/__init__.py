"""Comparison of tendon with MuJoCo; `make verify` (see docs/verification.md)."""
