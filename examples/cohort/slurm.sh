#!/usr/bin/env bash
# A run over many recordings as an array of Slurm jobs:
#
#   sbatch slurm.sh LIST OUT [OPTIONS OF calibrate]
#
# LIST has the path of a recording on each line. Before the time is up, or when the node is taken away,
# the recordings being worked on are finished and the job is queued again; it continues where it was.
#SBATCH --job-name=gravical
#SBATCH --array=1-8
#SBATCH --cpus-per-task=4
#SBATCH --mem-per-cpu=256M
#SBATCH --time=04:00:00
#SBATCH --signal=B:TERM@120
#SBATCH --requeue
#SBATCH --open-mode=append
set -uo pipefail
list=$1 out=$2
shift 2
gravical calibrate --each "@$list" -o "$out" "$@" \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    --threads "${SLURM_CPUS_PER_TASK:-1}" --resume --retries 3 --quiet &
run=$!
trap 'kill -TERM "$run"' TERM
wait "$run"
code=$?
# A signal ends the waiting, not the run.
while kill -0 "$run" 2>/dev/null; do
    wait "$run"
    code=$?
done
# The run may have ended between the signal and the loop: its own code is still there.
[ "$code" -gt 128 ] && { wait "$run"; code=$?; }
case $code in
    # Recordings that failed are rows of `gravical collect`, not a failure of the job.
    0 | 4) exit 0 ;;
    130) scontrol requeue "${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}" ;;
    *) exit "$code" ;;
esac
