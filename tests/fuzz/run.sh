#!/usr/bin/env bash
# ./do fuzz [SECONDS] [ENTRY ...]: each entry for so long (default 600 s of CPU time, all of them), one process at a
# time, from its corpus in tests/fuzz/corpus; what was found goes back there, minimised and small. Prints a table, and
# adds its rows to out/fuzz/table.md, so that entries done on several days stand in one. An input that hurts is left as
# out/fuzz/ENTRY-crash-... (or -timeout-, -oom-), and the exit status is 3. LIMBERG_FUZZ_NICE: how nice (default 10).
set -euo pipefail
cd "$(dirname "$0")/../.."

fuzzer=build-fuzz/limberg_fuzzer
seconds=${1:-600}
case $seconds in *[!0-9]* | '') echo "limberg: fuzz $seconds: expected a number of seconds" >&2; exit 2 ;; esac
shift || true
entries=$($fuzzer --entries)
for name in "$@"; do
  grep -qx -- "$name" <<<"$entries" || { echo "limberg: fuzz $name: no such entry; expected one of: $(tr '\n' ' ' <<<"$entries")" >&2; exit 2; }
done
[ $# = 0 ] || entries=$(printf '%s\n' "$@")

most_files=40 most_bytes=20000  # of an entry's corpus in the tree
out=out/fuzz
mkdir -p "$out"
work=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo "${TMPDIR:-/tmp}")/limberg-fuzz-XXXXXX")
trap 'rm -rf "$work"' EXIT
export TMPDIR=$work ASAN_OPTIONS=quarantine_size_mb=16:malloc_context_size=12 UBSAN_OPTIONS=print_stacktrace=1

# fuzz ARGUMENTS...: the fuzzer on this entry, with what its reader may take at most: of a volume 1.1 GB and the file.
fuzz() {
  local most=400
  case $LIMBERG_FUZZ_ENTRY in NRRD | MetaImage | NIfTI | DICOM) most=1200 ;; esac
  nice -n "${LIMBERG_FUZZ_NICE:-10}" "$fuzzer" -timeout=10 -malloc_limit_mb=$most -rss_limit_mb=$((2 * most + 400)) "$@"
}

# cpu_s: sets cpu to the CPU time of all processes that this one has waited for, in whole seconds. Not in a subshell:
# that would tell of its own.
cpu_s() {
  times >"$work/times"
  cpu=$(awk 'NR == 2 { for (i = 1; i <= 2; ++i) { split($i, a, /[ms]/); t += 60 * a[1] + a[2] } print int(t) }' \
    "$work/times")
}

row='| %-16s | %10s | %6s | %5s | %12s | %7s | %6s | %6s | %s |\n'
head=$(printf "$row" entry date clock cpu_s executions '1/s' edges files findings
  echo '|---|---|---|---|---|---|---|---|---|')
[ -s "$out/table.md" ] || echo "$head" >"$out/table.md"
echo "$head"
status=0
while read -r name; do
  export LIMBERG_FUZZ_ENTRY=$name
  tree=tests/fuzz/corpus/$name log=$out/$name.log
  mkdir -p "$tree" "$work/sound" "$work/new" "$work/merged"
  "$fuzzer" --corpus="$work/sound"
  cpu_s
  begin=$(date +%s) begin_cpu=$cpu took=0 runs=0 found=none
  : >"$log"
  # The fuzzer knows the clock only: beside other work it is called again until it has had its time.
  while [ "$took" -lt "$seconds" ] && [ "$found" = none ]; do
    fuzz -max_total_time=$((seconds - took)) -print_final_stats=1 -artifact_prefix="$out/$name-" \
      "$work/new" "$tree" "$work/sound" >"$log.part" 2>&1 || {
      status=3
      found=$(sed -n 's/.*Test unit written to //p' "$log.part" | head -1)
      : "${found:=see $log}"
    }
    cpu_s
    took=$((cpu - begin_cpu))
    n=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log.part")
    runs=$((runs + ${n:-0}))
    cat "$log.part" >>"$log"
  done
  rm -f "$log.part"
  clock=$(($(date +%s) - begin))
  edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -1)
  # The smallest inputs that reach more than the sound ones; those with a name of their own stay.
  cp "$work/sound/"* "$work/merged/"
  fuzz -merge=1 "$work/merged" "$tree" "$work/new" >>"$log" 2>&1 || true
  before=$(ls "$tree" | wc -l)
  find "$tree" -type f -regextype posix-extended -regex '.*/[0-9a-f]{40}' -delete
  files=0 bytes=0
  while read -r size file; do
    [ "$files" -lt $most_files ] && [ $((bytes + size)) -le $most_bytes ] || break
    cp "$work/merged/$file" "$tree/$file"
    files=$((files + 1)) bytes=$((bytes + size))
  done < <(find "$work/merged" -type f -regextype posix-extended -regex '.*/[0-9a-f]{40}' -printf '%s %f\n' | sort -n)
  printf "$row" "$name" "$(date +%F)" "$clock" "$took" "$runs" "$((runs / (took > 0 ? took : 1)))" "${edges:-?}" \
    "$before→$(ls "$tree" | wc -l)" "$found" |
    tee -a "$out/table.md"
  rm -rf "${work:?}"/sound "$work"/new "$work"/merged
done <<<"$entries"
exit $status
