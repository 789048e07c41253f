#!/usr/bin/env bash
# The moment after a loop closure: the gap of the cost to the full optimum and the ATE to it right
# after the updates that take a closure in, with an update a node and with one a closure; CPU ms of
# those updates, of a run of its own since comparisons empty the caches. Writes closures.csv, a chart
# a set and table to stdout. --large adds the cities of 30,000 and 100,000.
. "$(dirname "$0")/common.sh"
sets="kitti_00 kitti_02 kitti_05 kitti_06 kitti_07 M3500 intel sphere2500 torus3D parking-garage
  manhattan_3000 manhattan_10000 city_10000"
large=
preset=accurate
count=40
for option in "$@"; do
  case $option in
    --sets=*) sets=${option#*=} ;;
    --large) large="city_30000 city_100000" ;;
    --preset=*) preset=${option#*=} ;;
    --count=*) count=${option#*=} ;;
    *) usage "[--sets='kitti_00 city_1000'] [--large] [--preset=accurate] [--count=40]" ;;
  esac
done

# graph_of SET: a file of the public data or a world; prints its path.
graph_of() {
  local file
  for file in "$data/g2o/$1.g2o" "$data/kitti/graphs/$1.g2o"; do
    [[ -e $file ]] && { echo "$file"; return; }
  done
  case $1 in
    manhattan_*|city_*|sphere_*|torus_*) generate "${1%_*}" "${1##*_}" ;;
    *) echo "no data set $1 in $data" >&2; return 1 ;;
  esac
}

csv=$out/closures.csv
echo "set,update,closing,compared,gap_mean,gap_median,gap_p90,gap_max,ate_mean,ate_max,p50,p99,max" >"$csv"
for set in $sets $large; do
  graph=$(graph_of "$set")
  for update in nodes closures; do
    name=$out/closures_${set}_$update
    replay=("$hpgo" replay "$graph" --quiet --preset="$preset" --update_at="$update")
    "${replay[@]}" --compare_at="closures:$count" --chart="$name.svg" --stats_json="$name.json" \
      >"$name.txt"
    "${replay[@]}" --stats_json="$name.cpu.json" >/dev/null
    # The closures' CPU time comes after their wall time.
    cpu=$(sed -n '/"closures": {/,$p' "$name.cpu.json" | sed -n '/"cpu": {/,$p' >"$name.part"
      echo "$(json "$name.part" cpu p50) $(json "$name.part" cpu p99) $(json "$name.part" cpu max)")
    rm -f "$name.part"
    sed -n '/"closing": {/,$p' "$name.json" >"$name.part"
    echo "$(json "$name.part" closing updates) $(json "$name.part" closing compared)" \
      "$(json "$name.part" gap_percent mean) $(json "$name.part" gap_percent median)" \
      "$(json "$name.part" gap_percent p90) $(json "$name.part" gap_percent max)" \
      "$(json "$name.part" ate_m mean) $(json "$name.part" ate_m max) $cpu" |
      awk -v set="$set" -v update="$update" '{
        printf "%s,%s,%d,%d", set, update, $1, $2
        for (k = 3; k <= NF; ++k) printf ",%.3g", $k
        printf "\n" }' >>"$csv"
    rm -f "$name.part"
  done
done
echo "### Right after a closing update ($preset): gap and ATE to the full optimum, CPU time"
echo
table "$csv" set=set update="update at" closing="closing updates" compared=compared \
  gap_mean="gap, %: mean" gap_median=median gap_p90=p90 gap_max=max ate_mean="ATE, m: mean" \
  ate_max=max p50="CPU ms: p50" p99=p99 max=max
