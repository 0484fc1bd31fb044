#!/bin/sh
# The gate in plain shell: sweep, check, and act on the exit code.
study=${1:-suit.toml}

tendon sweep "$study" --out results/gate --overwrite --no-figures --quiet || exit $?
tendon check results/gate
case $? in
    0) echo "within limits" ;;
    4) echo "not within limits: see above"; exit 4 ;;
    *) echo "the run is damaged or is none"; exit 3 ;;
esac
