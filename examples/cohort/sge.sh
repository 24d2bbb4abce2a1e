#!/usr/bin/env bash
# A run over many recordings as an array job of (Sun, Univa, Open) Grid Engine:
#
#   qsub sge.sh LIST OUT [OPTIONS OF calibrate]
#
# LIST has the path of a recording on each line. Before the job is killed the recordings being worked on
# are finished, and the job is queued again (exit code 99); it continues where it was.
#$ -N gravical
#$ -t 1-8
#$ -pe smp 4
#$ -l h_rt=04:00:00
#$ -r y
#$ -notify
#$ -cwd
set -uo pipefail
list=$1 out=$2
shift 2
# The warning goes to all processes of the job: only this shell answers it.
(
    trap '' USR1 USR2
    exec gravical calibrate --each "@$list" -o "$out" "$@" \
        --shard "$SGE_TASK_ID/$SGE_TASK_LAST" \
        --threads "${NSLOTS:-1}" --resume --retries 3 --quiet
) &
run=$!
trap 'kill -TERM "$run"' USR1 USR2 TERM
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
    130) exit 99 ;;
    *) exit "$code" ;;
esac
