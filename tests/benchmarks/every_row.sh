#!/bin/bash
# Every row of the table in docs/measurements/bench-results.md, on a machine with nothing else at work:
#   bash tests/benchmarks/every_row.sh OUT 2>&1 | tee every_row.log
# with gimbal-hil[bench] on the path; compiles everything anew into OUT/cache, twenty minutes in all.
set -u
out=$(realpath -m "${1:?the folder for the pages}")
mkdir -p "$out" && cd "$out" || exit 2
export GIMBAL_HIL_CACHE="$out/cache" TIMEFORMAT='%R s wall, %U s of processors'
rm -rf "$GIMBAL_HIL_CACHE"
say() { echo "== $* (load $(cut -d' ' -f1 /proc/loadavg))"; }

say "first demo, nothing compiled" && time gimbal-hil demo --out first_demo --force
say "demo, everything compiled" && time gimbal-hil demo --out second_demo --force
gimbal-hil warm
say "plant, effects, paths, --help" && gimbal-hil bench speed --repeats 21 --out speed --force
say "the daemon's computing and wake-ups"
gimbal-hil bench realtime --link unix --link serial --link slcan --rate 1000 --seconds 120 --out realtime --force
say "search on 120 s of two axes" && gimbal-hil bench search --workers 2 --out search --force
say "what identify needs, then identify"
time gimbal-hil experiment sliding --seed 1 --out sliding --force --json > sliding.json
time gimbal-hil experiment presliding --seed 1 --out presliding --force --json > presliding.json
time gimbal-hil identify sliding presliding --workers 2 --out identified --force --json > identified.json
for antennas in 100 1000; do
  for workers in 1 2; do
    say "campaign, $antennas antennas, $workers processes"
    time gimbal-hil campaign step --spread friction.coulomb=5% --antennas $antennas --workers $workers \
      --out many --force --json > many.json
    md5sum many/antennas.csv
  done
done
