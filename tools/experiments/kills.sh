#!/usr/bin/env bash
# Replays that are killed (SIGKILL) at random moments while they save their state again and again, and
# resumed from what is on the disk: the poses at the end against those of an uninterrupted replay, bit
# for bit. Says how many were killed, how many of them resumed in the middle, and fails at the first
# that differs.
. "$(dirname "$0")/common.sh"
count=200
world=city
nodes=3000
for option in "$@"; do
  case $option in
    --count=*) count=${option#*=} ;;
    --world=*) world=${option#*=} ;;
    --nodes=*) nodes=${option#*=} ;;
    *) usage "[--count=200] [--world=city] [--nodes=3000]" ;;
  esac
done
graph=$(generate "$world" "$nodes")
RANDOM=1
whole=$out/whole.g2o state=$out/killed.state resumed=$out/resumed.g2o
replay=("$hpgo" replay "$graph" --quiet)
begin=$(date +%s%N)
"${replay[@]}" --save="$out/whole.state" --save_every=20 --output="$whole" >"$out/log.txt"
elapsed=$((($(date +%s%N) - begin) / 1000))  # microseconds
killed=0 middle=0
for ((k = 0; k < count; ++k)); do
  rm -f "$state" "$resumed"
  "${replay[@]}" --save="$state" --save_every=20 --output="$resumed" >"$out/log.txt" 2>&1 &
  child=$!
  at=$((elapsed * (RANDOM % 1000) / 1000))
  sleep "$(printf '%d.%06d' $((at / 1000000)) $((at % 1000000)))"
  kill -KILL $child 2>/dev/null || true
  wait $child 2>/dev/null && continue  # it had ended
  killed=$((killed + 1))
  resume=()
  if [[ -e $state ]]; then
    resume=(--resume="$state")
    middle=$((middle + 1))
  fi
  "${replay[@]}" "${resume[@]}" --output="$resumed" >"$out/log.txt" 2>&1
  cmp "$whole" "$resumed" || { echo "differs after the kill at $at us, state kept" >&2; exit 1; }
done
echo "$count replays of $world $nodes: $killed killed, $middle of them resumed in the middle, all equal"
