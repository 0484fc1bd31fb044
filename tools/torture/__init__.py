"""Run folders, disks and files under torture, for `make test` and `make torture`."""
