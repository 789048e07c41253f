#!/usr/bin/env bash
# The paper's Table 1: KITTI segment errors (translation in %, rotation in mrad/m) and ATE (m) of
# full optimization and of an online replay with an update at every frame, for the graphs with real
# stereo odometry that have loop closures: without one there is nothing to optimize. Writes kitti.csv
# and a table to stdout.
. "$(dirname "$0")/common.sh"
sequences="00 02 05 06 07"
for option in "$@"; do
  case $option in
    --sequences=*) sequences=${option#*=} ;;
    *) usage "[--sequences='00 06']" ;;
  esac
done

# evaluate NAME ESTIMATE: "translation %,rotation mrad/m,ATE m".
evaluate() {
  local figures=$out/kitti_$1.json
  "$hpgo" evaluate "$2" --quiet --reference="$data/kitti/gt/$sequence.txt" --plane=xz \
    --json="$figures" >/dev/null
  echo "$(json "$figures" kitti translation_ratio) $(json "$figures" kitti rotation_rad_per_m)" \
    "$(json "$figures" ate rmse)" | awk '{ printf "%.4f,%.5f,%.4f", 100 * $1, 1000 * $2, $3 }'
}

csv=$out/kitti.csv
echo "sequence,full_t,full_r,full_ate,partial_t,partial_r,partial_ate,paper_t,paper_r,paper_ate,worst_percent" >"$csv"
for sequence in $sequences; do
  graph=$data/kitti/graphs/kitti_$sequence.g2o
  "$hpgo" optimize "$graph" --quiet --output="$out/kitti_${sequence}_full.g2o"
  for preset in accurate paper; do
    "$hpgo" replay "$graph" --quiet --preset=$preset --output="$out/kitti_${sequence}_$preset.g2o" \
      >"$out/kitti_${sequence}_$preset.txt"
  done
  full=$(evaluate "${sequence}_full" "$out/kitti_${sequence}_full.g2o")
  partial=$(evaluate "${sequence}_accurate" "$out/kitti_${sequence}_accurate.g2o")
  paper=$(evaluate "${sequence}_paper" "$out/kitti_${sequence}_paper.g2o")
  # By how much partial is worse than full at most, in %; negative where it is better in all three.
  worst=$(echo "$full,$partial" | awk -F, '{
    worst = -1e9
    for (k = 1; k <= 3; ++k) { d = 100 * ($(k + 3) / $k - 1); if (d > worst) worst = d }
    printf "%.2f", worst }')
  echo "$sequence,$full,$partial,$paper,$worst" >>"$csv"
done
echo "### KITTI: t in %, r in mrad/m over segments of 100 to 800 m, ATE in m"
echo
table "$csv" sequence=sequence full_t="full: t" full_r=r full_ate=ATE partial_t="partial: t" \
  partial_r=r partial_ate=ATE worst_percent="worse by at most, %" paper_t="paper's preset: t" \
  paper_r=r paper_ate=ATE
