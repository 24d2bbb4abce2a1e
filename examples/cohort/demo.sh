#!/usr/bin/env bash
# Fifty simulated sensors from their recordings to a report, from a fresh clone:
#
#   examples/cohort/demo.sh [FOLDER [NUMBER]]
#
# GRAVICAL names a program in place of `cargo run --release`. In a terminal the report is opened.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
folder=${1:-$(mktemp -d)}
gravical() {
    if [ -n "${GRAVICAL:-}" ]; then "$GRAVICAL" "$@"; else cargo run --quiet --release --locked -- "$@"; fi
}
for seed in $(seq "${2:-50}"); do
    gravical simulate poses -o "$folder/recordings/unit-$seed" --seed "$seed" --free 3 --force --quiet
done
# 4: of one or the other the quality gate failed. It is in the report.
gravical calibrate --each "$folder/recordings" -o "$folder/out" --gravity 9.80665 --resume --quiet || [ $? = 4 ]
gravical collect "$folder/out" -o "$folder/cohort.csv" --report "$folder/cohort.html" --force || [ $? = 4 ]
if [ -t 1 ]; then
    open=$(command -v xdg-open || command -v open || true)
    [ -z "$open" ] || "$open" "$folder/cohort.html" >/dev/null 2>&1 || true
fi
