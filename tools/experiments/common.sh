# What the experiments share; read by them, not run by itself.
# Every experiment is called as EXPERIMENT.sh OUT [options] with OUT a directory for all it writes.
# HPGO names another program than that of the release build, DATA another folder with the public
# data sets (g2o/ and kitti/).
set -euo pipefail
export LC_ALL=C

repo=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
hpgo=${HPGO:-$repo/build/release/bin/hpgo}
data=${DATA:-$repo/../shared/data}

usage() {
  echo "usage: $(basename "$0") OUT $*" >&2
  exit 1
}

[[ -x $hpgo ]] || { echo "no program $hpgo: cmake --preset release && cmake --build --preset release" >&2; exit 1; }
[[ $# -ge 1 && $1 != -* ]] || usage "[options]"
out=$1
shift
mkdir -p "$out"

# The graph of so many nodes in a world: generate WORLD NODES; prints its path.
generate() {
  local file=$out/$1_$2.g2o
  [[ -s $file ]] || "$hpgo" generate --quiet --world="$1" --nodes="$2" --output="$file"
  echo "$file"
}

# A markdown table of columns of a CSV file: table FILE COLUMN=TITLE...
table() {
  local file=$1
  shift
  awk -F, -v spec="$(IFS=';'; echo "$*")" '
    NR == 1 {
      for (k = 1; k <= NF; ++k) at[$k] = k
      n = split(spec, parts, ";")
      head = "|"; rule = "|"
      for (k = 1; k <= n; ++k) {
        split(parts[k], pair, "=")
        if (!(pair[1] in at)) { print "no column " pair[1] > "/dev/stderr"; exit 1 }
        column[k] = at[pair[1]]
        head = head " " pair[2] " |"; rule = rule "---|"
      }
      print head; print rule; next
    }
    { row = "|"; for (k = 1; k <= n; ++k) row = row " " $(column[k]) " |"; print row }' "$file"
}

# A number of a JSON file as hpgo writes it: the first KEY after the first SECTION.
json() {
  awk -v section="\"$2\"" -v key="\"$3\": " '
    index($0, section) { found = 1 }
    found && (at = index($0, key)) {
      value = substr($0, at + length(key)); sub(/,$/, "", value); print value; exit
    }' "$1"
}
