#!/usr/bin/env bash
# The paper's Figure 4: the time of an update against the number of nodes when it solves the whole
# graph, the top level only, or a window on every level; beside them the paper's own preset. Writes
# modes_WORLD.csv, tables to stdout and modes_WORLD.svg. Mean CPU time of an update: of the last
# tenth of a replay for the windows, of the last 200 updates for the top, of the last 4 for full
# solves, of which each costs seconds on large graphs.
. "$(dirname "$0")/common.sh"
sizes="1000 3000 10000 30000 100000"
worlds="city manhattan"
engine=block
for option in "$@"; do
  case $option in
    --sizes=*) sizes=${option#*=} ;;
    --worlds=*) worlds=${option#*=} ;;
    --engine=*) engine=${option#*=} ;;
    *) usage "[--sizes='1000 3000'] [--worlds='city manhattan'] [--engine=block]" ;;
  esac
done

# measure GRAPH flags...: the mean CPU ms of the updates that count.
measure() {
  local graph=$1 summary=$out/modes_run.csv
  shift
  rm -f "$summary"
  "$hpgo" replay "$graph" --quiet --engine="$engine" --summary_csv="$summary" "$@" >/dev/null
  table "$summary" all_cpu_mean_ms=mean | awk 'END { print $2 }'
}

for world in $worlds; do
  figures=$out/modes_$world.csv
  echo "nodes,full,top,partial,paper" >"$figures"
  for nodes in $sizes; do
    graph=$(generate "$world" "$nodes")
    # What came before does not matter to these two.
    full=$(measure "$graph" --solve_every=50 --measure_mode=full --measure_updates=4)
    top=$(measure "$graph" --solve_every=50 --measure_mode=top --measure_updates=200)
    partial=$(measure "$graph" --stats_from=0.9)
    paper=$(measure "$graph" --preset=paper --stats_from=0.9)
    echo "$nodes,$full,$top,$partial,$paper" >>"$figures"
  done
  echo "### $world: mean CPU ms an update, engine $engine"
  echo
  table "$figures" nodes=nodes full="full" top="top only" partial="partial" \
    paper="partial, the paper's preset"
  echo
  "$hpgo" chart "$figures" --quiet --x=nodes --log \
    --y="full,top=top only,partial,paper=partial: the paper's preset" --x_label=nodes \
    --y_label="CPU ms an update" --title="$world: the three modes (the paper's Figure 4)" \
    --output="$out/modes_$world.svg"
done
