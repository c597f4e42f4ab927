#!/usr/bin/env bash
# Run fuzzing targets for some seconds each: run.sh BUILD_FOLDER SECONDS [TARGET ...]. What they
# learn stays in BUILD_FOLDER/fuzz/TARGET; an input that breaks a target is kept there as crash-*
# (or leak-*, timeout-*) and ends the script with status 1. Repeat it with
# BUILD_FOLDER/tests/fuzz/fuzz_TARGET FILE.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
(($# >= 2)) || {
  echo "usage: tests/fuzz/run.sh BUILD_FOLDER SECONDS" \
    "[scene|formula|table|import|history|checkpoint|snapshots ...]" >&2
  exit 1
}
folder=$PWD/$1
seconds=$2
shift 2
(($# > 0)) || set -- scene formula table import history checkpoint snapshots

# seeds TARGET: put first inputs into seeds/TARGET and words to insert into TARGET.dict.
seeds() {
  mkdir -p "seeds/$1"
  echo '"0"' >"$1.dict"
  case $1 in
    scene)
      local file
      for file in "$root"/problems/*/scene.yaml "$root"/tests/scenes/*/*.yaml; do
        cp -- "$file" "seeds/scene/$(basename "$(dirname "$file")")-$(basename "$file")"
      done
      grep -oh '`[a-z_][a-z_.]*`' "$root/docs/scene.md" | tr -d '`' | tr . '\n' | sort -u |
        sed 's/.*/"&"/' >scene.dict
      ;;
    formula)
      grep -oh ': [^:{}]*' "$root"/problems/*/scene.yaml "$root"/tests/scenes/good/*.yaml |
        sed 's/^: *//; s/[]["]//g; s/,.*//' | sort -u | split -l 1 - seeds/formula/line-
      printf '"%s"\n' sqrt atan2 exp theta pi MPa 'm^2' 'kg/m^3' deg spacing '?' '&&' '1e308' >formula.dict
      ;;
    table)
      printf '# a comment\nt,u\n0, 1.5\n1,2\n\n2.5,-3e-7\n' >seeds/table/three
      printf 'n,u , t\r\n1,2,3\r\n1,2,4' >seeds/table/turned
      ;;
    import)
      printf '# plane\nx [mm],y,volume [mm^3],region\n0,0,1,a\n1,2.5e-3,1,a b\n' >seeds/import/plane
      printf 'x,y,z,spacing,horizon,note\r\n0,0,0,1,3,-\r\n1,0,0,1,3,n' >seeds/import/solid
      printf '"%s"\n' x y z volume spacing horizon region note '[mm]' '(m^3)' ',' >import.dict
      ;;
    history)
      printf 'time,kinetic,grip.reaction.x\n0,1,2\n1e-7,2.5,nan\n2e-7,inf,-3\n' >seeds/history/three
      ;;
    checkpoint | snapshots)
      : >"seeds/$1/empty" # its mutator begins with a good one
      ;;
  esac
}

root=$PWD
mkdir -p "$folder/fuzz"
cd -- "$folder/fuzz"
for target in "$@"; do
  mkdir -p "$target"
  seeds "$target"
  "$folder/tests/fuzz/fuzz_$target" "$target" "seeds/$target" -max_total_time="$seconds" \
    -dict="$target.dict" -artifact_prefix="$target/" -max_len=65536 -timeout=20 -rss_limit_mb=3000 \
    -print_final_stats=1 -verbosity=0 >"$target.log" 2>&1 || {
    tail -n 60 "$target.log"
    exit 1
  }
  printf '%s: %s inputs in %s s, none breaks it\n' "$target" \
    "$(sed -n 's/^stat::number_of_executed_units: *//p' "$target.log")" "$seconds"
done
