#!/usr/bin/env bash
# A Slurm array, a task for each line of a list of settings:
#
#     sbatch --array=1-$(wc -l < cases.txt) slurm.sh suit.toml cases.txt
#
# A task that is stopped goes on where it was when it is submitted again.
#SBATCH --job-name=tendon
#SBATCH --cpus-per-task=2
#SBATCH --time=00:30:00
set -euo pipefail

study=$1 list=$2
setting=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$list")
run="results/task-${SLURM_ARRAY_TASK_ID}"

tendon sweep "$study" --set "$setting" --out "$run" --jobs "${SLURM_CPUS_PER_TASK:-2}" --no-figures --quiet --resume
tendon check "$run"
