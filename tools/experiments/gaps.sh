#!/usr/bin/env bash
# The gap of the cost to the full optimum at 25, 50, 75 and 100 % of a replay, in percent, for every
# preset; also after Refine for those that know when they are at rest. Writes gaps.csv and a table to
# stdout.
. "$(dirname "$0")/common.sh"
presets="accurate fast eager paper"
sets="sphere2500 torus3D parking-garage manhattan_3000 manhattan_10000 city_10000"
engine=block
for option in "$@"; do
  case $option in
    --presets=*) presets=${option#*=} ;;
    --sets=*) sets=${option#*=} ;;
    --engine=*) engine=${option#*=} ;;
    *) usage "[--presets='accurate paper'] [--sets='sphere2500 city_1000'] [--engine=block]" ;;
  esac
done

csv=$out/gaps.csv
echo "set,preset,25,50,75,100,refined,closure_p50,closure_p99" >"$csv"
for set in $sets; do
  graph=$data/g2o/$set.g2o
  [[ -e $graph ]] || graph=$(generate "${set%_*}" "${set##*_}")
  for preset in $presets; do
    stats=$out/gaps_${set}_$preset.json
    refine=--refine
    [[ $preset == eager || $preset == paper ]] && refine=--norefine
    "$hpgo" replay "$graph" --quiet --preset="$preset" --engine="$engine" \
      --compare_full=25,50,75,100 $refine --stats_json="$stats" >"${stats%.json}.txt"
    gaps=$(awk -F': ' '/"gap_percent":/ { printf "%.4f,", $2 }' "$stats")
    refined=$(json "$stats" refine gap_percent_after)
    echo "$set,$preset,$gaps${refined:--},$(json "$stats" closures p50),$(json "$stats" closures p99)" |
      awk -F, 'BEGIN { OFS = "," } { for (k = 7; k <= 9; ++k) if ($k != "-") $k = sprintf("%.4g", $k); print }' >>"$csv"
  done
done
echo "### Gap to the full optimum, %, at so many percent of a replay (engine $engine)"
echo
table "$csv" set=set preset=preset 25="25 %" 50="50 %" 75="75 %" 100="100 %" refined="refined" \
  closure_p50="closure p50, wall ms" closure_p99="p99"
