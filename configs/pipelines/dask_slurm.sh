#!/usr/bin/env bash
# One sweep on several nodes: a Dask scheduler on the first node of the job, a worker for each task, all in one allocation.
#
#     sbatch --nodes=4 dask_slurm.sh suit.toml results/suit
#
# A job that is stopped goes on where it was when it is submitted again. Every node must see the folder of the results.
#SBATCH --job-name=tendon-dask
#SBATCH --ntasks-per-node=1
#SBATCH --cpus-per-task=8
#SBATCH --time=01:00:00
set -euo pipefail

study=$1 run=$2
where=$(mktemp -d "${PWD}/dask-XXXXXX")
trap 'kill $(jobs -p) 2>/dev/null || true; wait; rm -rf "$where"' EXIT

dask scheduler --port 0 --dashboard-address :0 --scheduler-file "$where/scheduler.json" 2>"$where/scheduler.log" &
srun dask worker --scheduler-file "$where/scheduler.json" --nthreads "${SLURM_CPUS_PER_TASK:-1}" --no-dashboard \
    --local-directory "$where" 2>"$where/workers.log" &

for _ in $(seq 60); do [ -s "$where/scheduler.json" ] && break; sleep 1; done
scheduler=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["address"])' "$where/scheduler.json")
tendon sweep "$study" --out "$run" --scheduler "$scheduler" --no-figures --quiet --resume
