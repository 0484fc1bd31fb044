"""Parquet tables with units, checksums and the study they answer: written whole or not at all, verified when read."""
