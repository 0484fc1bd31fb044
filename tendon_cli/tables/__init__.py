"""Parquet tables with units, checksums and their study: written whole or not at all, verified."""
