"""Comparison of tendon with MuJoCo (`make verify`, docs/verification.md) and with the paper."""
