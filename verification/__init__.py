"""Comparison of tendon with MuJoCo (`make verify`, verification/mujoco.md) and with the paper."""
