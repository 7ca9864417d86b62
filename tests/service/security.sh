#!/usr/bin/env bash
# How exposed the units are, as systemd-analyze has it, beside the goal. 77 (skipped) without it.
#   tests/service/security.sh FOLDER   where the configured units are
set -euo pipefail
command -v systemd-analyze >/dev/null || { echo "skipped, no systemd-analyze"; exit 77; }
[[ $(systemd-analyze --help) == *--offline* ]] || { echo "skipped, systemd before 251"; exit 77; }
goal=2.0 failed=0 seen=0
for unit in "$1"/*.service; do
  line=$(systemd-analyze security --offline=true --no-pager "$unit" 2>/dev/null | tail -n 1)
  level=$(sed -n 's/.*: \([0-9.]*\) .*/\1/p' <<<"$line")
  [ -n "$level" ] || { echo "FAILED: $unit: $line"; exit 1; }
  seen=$((seen + 1))
  verdict=ok
  awk -v level="$level" -v goal=$goal 'BEGIN { exit !(level > goal) }' && verdict=FAILED failed=1
  printf '%-20s %s, goal <= %s: %s\n' "$(basename "$unit")" "$level" $goal $verdict
  # Files written by a unit are not writable by others, nor by its group.
  grep -qx 'UMask=00[27]7' "$unit" || { echo "FAILED: $unit: expected UMask=0027 or 0077"; failed=1; }
  # Anything that systemd does not understand is a fault of ours: it would be left out silently.
  complaints=$(systemd-analyze security --offline=true --no-pager "$unit" 2>&1 >/dev/null |
    grep -v "is not executable\|Failed to \(open\|connect\)" || true)
  [ -z "$complaints" ] || { echo "FAILED: $complaints"; failed=1; }
done
[ $seen = 6 ] || { echo "FAILED: $seen units, expected 6"; exit 1; }
exit $failed
