#!/usr/bin/env bash
# How often `hpgo optimize` ends above the best known minimum: random graphs whose rotations are
# measured with a noise of 0.4 to 0.8 rad per axis. The best known is the lowest end of every start,
# of both engines, of the true poses and of both programs, where BEFORE names an older one to
# compare with. Writes hard_starts.csv and a table to stdout.
. "$(dirname "$0")/common.sh"
worlds="sphere:3 torus:3 grid:3 manhattan:2"
noises="0.4 0.6 0.8"
seeds=30
nodes=60
above=1e-4
for option in "$@"; do
  case $option in
    --worlds=*) worlds=${option#*=} ;;
    --noises=*) noises=${option#*=} ;;
    --seeds=*) seeds=${option#*=} ;;
    --nodes=*) nodes=${option#*=} ;;
    *) usage "[--worlds='sphere:3 grid:2'] [--noises='0.4 0.8'] [--seeds=30] [--nodes=60]" ;;
  esac
done

# The cost at the end of an optimization: end PROGRAM FILE [flags]; infinite if there is none.
end() {
  local program=$1
  shift
  "$program" optimize "$@" --quiet --stats_json="$out/stats.json" >/dev/null 2>&1 || true
  local cost
  cost=$(json "$out/stats.json" status cost_after)
  echo "${cost:-inf}"
  rm -f "$out/stats.json"
}

csv=$out/hard_starts.csv
echo "world,noise,graphs,before,before_percent,after,after_percent" >"$csv"
for world in $worlds; do
  for noise in $noises; do
    ends=$out/ends_${world/:/}_$noise.txt
    : >"$ends"
    for seed in $(seq 1 "$seeds"); do
      graph=$out/graph.g2o
      "$hpgo" generate --quiet --world="${world%:*}" --dim="${world#*:}" --nodes="$nodes" \
        --seed="$seed" --noise_rotation="$noise" --noise_translation=0.1 --output="$graph" \
        --ground_truth="$out/truth.g2o"
      { grep ^VERTEX "$out/truth.g2o"; grep ^EDGE "$graph"; } >"$out/from_truth.g2o"
      others=
      for flags in --engine=ceres@--init=joint_chordal --init=file --init=spanning_tree --init=chordal \
        --init=joint_chordal; do
        # shellcheck disable=SC2086
        others+=" $(end "$hpgo" "$graph" ${flags/@/ })"
      done
      others+=" $(end "$hpgo" "$out/from_truth.g2o" --init=file)"
      echo "$(end "${BEFORE:-$hpgo}" "$graph") $(end "$hpgo" "$graph")$others" >>"$ends"
    done
    # The first two columns against the lowest of all.
    awk -v above="$above" -v world="${world/:/ }D" -v noise="$noise" '
      { best = $1 + 0
        for (k = 2; k <= NF; ++k) if ($k != "inf" && $k + 0 < best) best = $k + 0
        for (k = 1; k <= 2; ++k) { higher[k] += $k > best * (1 + above); gap[k] += $k / best - 1 } }
      END { printf "%s,%s,%d,%d,%.2f,%d,%.2f\n", world, noise, NR, higher[1], 100 * gap[1] / NR,
                   higher[2], 100 * gap[2] / NR }' "$ends" >>"$csv"
  done
done
rm -f "$out/graph.g2o" "$out/truth.g2o" "$out/from_truth.g2o"
echo "### Ends above the best known minimum by more than $above of it, and the mean excess in percent"
echo
table "$csv" world=world noise="noise, rad" graphs=graphs before=before \
  before_percent="excess before, %" after=after after_percent="excess, %"
