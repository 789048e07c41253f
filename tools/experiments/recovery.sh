#!/usr/bin/env bash
# How fast a replay takes in a loop closure at its end that is far off: its chi2 is FACTOR times an
# edge's mean. The gap to the full optimum, in percent, after so many more updates, each at the
# default cap of windows or with so many seconds. Writes recovery.csv and a table to stdout.
. "$(dirname "$0")/common.sh"
sets="sphere2500 torus3D parking-garage manhattan_3000 manhattan_10000 city_10000"
factor=1e5
seconds=0.02
for option in "$@"; do
  case $option in
    --sets=*) sets=${option#*=} ;;
    --factor=*) factor=${option#*=} ;;
    --seconds=*) seconds=${option#*=} ;;
    *) usage "[--sets='sphere2500 city_1000'] [--factor=1e5] [--seconds=0.02]" ;;
  esac
done

csv=$out/recovery.csv
echo "set,limit,1,2,5,10,20,50,100,slowest" >"$csv"
for set in $sets; do
  graph=$data/g2o/$set.g2o
  [[ -e $graph ]] || graph=$(generate "${set%_*}" "${set##*_}")
  for limit in default "$seconds s"; do
    stats=$out/recovery_$set.json
    # With a time limit for every update the replay itself would take that long at each node.
    flags=
    [[ $limit == default ]] || flags="--update_seconds=$seconds --solve_every=10"
    # shellcheck disable=SC2086
    "$hpgo" replay "$graph" --quiet --far_closure="$factor" $flags --stats_json="$stats" >/dev/null
    # One at rest earlier stays where it is.
    awk -v set="$set" -v limit="$limit" '
      /"far_closure":/ { found = 1 }
      found && /"slowest_ms":/ { split($0, p, /[:,]/); slowest = p[2] }
      found && /"updates":/ { split($0, p, /[:,]/); updates = p[2] + 0 }
      found && /"gap_percent":/ { split($0, p, /[:,]/); gap[++n] = p[2] }
      END {
        line = set "," limit
        for (k = 1; k <= 7; ++k) line = line sprintf(",%.3g", gap[k < n ? k : n])
        printf "%s,%.1f\n", line, slowest
      }' "$stats" >>"$csv"
  done
done
echo "### Gap to the full optimum, %, so many updates after a far-off closure (chi2 $factor times the mean)"
echo
table "$csv" set=set limit="an update" 1=1 2=2 5=5 10=10 20=20 50=50 100=100 \
  slowest="slowest update, ms"
