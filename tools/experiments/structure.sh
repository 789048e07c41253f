#!/usr/bin/env bash
# The hierarchy grown node by node over public and generated graphs: level sizes relative to the
# graph (the paper's Figure 2), reduction between levels, group sizes, insertion time. Writes
# structure_SET.{json,txt,svg} and a table to stdout. T = 300 is the paper's.
. "$(dirname "$0")/common.sh"
sets="sphere2500 torus3D parking-garage M3500 manhattan_100000 city_100000"
top=300
for option in "$@"; do
  case $option in
    --sets=*) sets=${option#*=} ;;
    --max_top_nodes=*) top=${option#*=} ;;
    *) usage "[--sets='sphere2500 city_1000'] [--max_top_nodes=300]" ;;
  esac
done

csv=$out/structure.csv
echo "set,levels,sizes,reductions,largest,insert_p50,insert_p99" >"$csv"
for set in $sets; do
  graph=$data/g2o/$set.g2o
  [[ -e $graph ]] || graph=$(generate "${set%_*}" "${set##*_}")
  figures=$out/structure_$set.json
  "$hpgo" hierarchy "$graph" --quiet --max_top_nodes="$top" --json="$figures" \
    --output="$out/structure_$set.svg" >/dev/null
  "$hpgo" hierarchy "$graph" --quiet --max_top_nodes="$top" >"$out/structure_$set.txt"
  awk -v set="$set" '
    /"nodes":/ { split($0, p, /[:,]/); sizes = sizes (levels++ ? " / " : "") p[2] + 0 }
    /"reduction":/ { split($0, p, /[:,]/); if (p[2] > 0) reductions = reductions sprintf("%s%.2f", reductions == "" ? "" : " / ", p[2]) }
    /"groups_by_size":/ { inside = 1; count = 0; next }
    inside && /\]/ { inside = 0; if (count > largest) largest = count }
    inside { ++count }
    /"p50":/ { split($0, p, /[:,]/); p50 = p[2] }
    /"p99":/ { split($0, p, /[:,]/); p99 = p[2] }
    END { printf "%s,%d,%s,%s,%d,%.2f,%.2f\n", set, levels, sizes, reductions, largest, p50, p99 }
  ' "$figures" >>"$csv"
done
echo "### The hierarchy, grown node by node (T = $top)"
echo
table "$csv" set=set levels=levels sizes="nodes a level" reductions="reduction" \
  largest="largest group" insert_p50="insertion p50, us" insert_p99="p99"
