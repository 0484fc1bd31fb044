"""Figures of an answer of `tendon design`: tolerance over two choices, the window along each, the front."""
