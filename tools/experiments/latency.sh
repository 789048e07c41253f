#!/usr/bin/env bash
# Latency of an update against the number of nodes, for both engines: the last tenth of a replay
# with an update at every node. Writes latency.csv, tables to stdout and latency_WORLD.svg.
# CPU time of one thread; it does not grow when others use the machine.
. "$(dirname "$0")/common.sh"
sizes="1000 3000 10000 30000 100000"
worlds="city manhattan"
engines="block ceres"
preset=accurate
large=
for option in "$@"; do
  case $option in
    --large) large="300000 1000000" ;;  # of the city
    --sizes=*) sizes=${option#*=} ;;
    --worlds=*) worlds=${option#*=} ;;
    --engines=*) engines=${option#*=} ;;
    --preset=*) preset=${option#*=} ;;
    *) usage "[--large] [--sizes='1000 3000'] [--worlds='city manhattan'] [--engines='block ceres'] [--preset=accurate]" ;;
  esac
done

rm -f "$out/latency.csv"
for world in $worlds; do
  summary=$out/latency_$world.csv
  rm -f "$summary"
  all_sizes=$sizes
  [[ $world == city ]] && all_sizes="$sizes $large"
  for nodes in $all_sizes; do
    graph=$(generate "$world" "$nodes")
    for engine in $engines; do
      # A million nodes with Ceres' windows would take hours and show nothing new.
      [[ $engine == ceres && $nodes -gt 100000 ]] && continue
      "$hpgo" replay "$graph" --quiet --preset="$preset" --engine="$engine" --stats_from=0.9 \
        --summary_csv="$summary" >"$out/latency_${world}_${nodes}_$engine.txt"
    done
  done
  echo "### $world: latency of an update, CPU ms, in the last tenth of the replay (preset $preset)"
  echo
  table "$summary" nodes=nodes edges=edges engine=engine \
    all_cpu_p50_ms="all: p50" all_cpu_p99_ms=p99 all_cpu_max_ms=max \
    closures_cpu_p50_ms="closures: p50" closures_cpu_p99_ms=p99 closures_cpu_max_ms=max \
    odometry_cpu_p50_ms="odometry: p50" odometry_cpu_p99_ms=p99 odometry_cpu_max_ms=max
  echo
  echo "### $world: where the wall time goes, mean ms an update; memory"
  echo
  table "$summary" nodes=nodes engine=engine insert_ms=insert merge_ms=merge examine_ms=examine \
    top_ms=top windows_ms=windows other_ms=other all_wall_p50_ms="wall p50" \
    all_wall_p99_ms="wall p99" bytes_per_node="bytes a node" peak_memory_mb="peak MB" \
    total_seconds="replay s"
  echo
  "$hpgo" chart "$summary" --quiet --x=nodes --y=closures_cpu_p50_ms=p50,closures_cpu_p99_ms=p99 \
    --by=engine --log --x_label=nodes --y_label="CPU ms an update with a loop closure" \
    --title="$world: latency against the number of nodes" --output="$out/latency_$world.svg"
  { [[ -s $out/latency.csv ]] && tail -n +2 "$summary" || cat "$summary"; } >>"$out/latency.csv"
done
