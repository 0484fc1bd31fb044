"""Proofs that a window holds at every elbow angle, load and posture, and over a box of numbers."""
