#!/usr/bin/env bash
# Builds Styled and shows it at work: the built-in synthetic performer is streamed at 120 Hz into the
# daemon, the shipped weights restyle it, the style switches every few seconds, and the terminal
# monitor draws input and styled figure side by side. Ctrl-C, or q in the monitor, ends it.
#   --seconds N      end by itself after N seconds
#   --performers N   that many performers (default 1)
#   --plain          no full-screen monitor: a picture and a line every two seconds
#   --no-build       use the binaries that are there
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/sim/setup.sh"

seconds=0
performers=1
plain=no
build=yes
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds | --performers)
      if ! [[ "${2:-}" =~ ^[1-9][0-9]*$ ]]; then
        echo "$1: expected a whole number above 0, found '${2:-nothing}'" >&2
        exit 2
      fi
      if [ "$1" = --seconds ]; then seconds=$2; else performers=$2; fi
      shift
      ;;
    --plain) plain=yes ;;
    --no-build) build=no ;;
    -h | --help)
      sed -n '2,8s/^# \{0,1\}//p' "$0"
      exit 0
      ;;
    *)
      echo "unknown option '$1'; see --help" >&2
      exit 2
      ;;
  esac
  shift
done
[ -t 1 ] || plain=yes

if [ "$build" = yes ]; then
  styled_install run
  echo "building (the first time takes a few minutes; log in build/release.log)"
  styled_build release -DSTYLED_TESTS=OFF -DSTYLED_TRAIN=OFF
fi
bin=$root/build/release/bin
for program in styled stylesim stylectl stylemon; do
  [ -x "$bin/$program" ] || { echo "$bin/$program is missing: run without --no-build" >&2; exit 1; }
done

work=$(mktemp -d)
pids=()
stop() {
  trap - EXIT INT TERM
  for pid in "${pids[@]}"; do kill -TERM "$pid" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$work"
}
trap stop EXIT
stopped=no
trap 'stopped=yes' INT TERM

cat >"$work/styled.toml" <<'TOML'
[[source]]
name = "demo"
type = "udp"
listen = "127.0.0.1:0"
[publish]
address = "tcp://127.0.0.1:0"
[control]
address = "tcp://127.0.0.1:0"
TOML
# Each program runs in its own process group, so that Ctrl-C reaches this script, which ends them.
setsid "$bin/styled" --config "$work/styled.toml" --ready-file "$work/ready.json" \
  >"$work/styled.log" 2>&1 &
pids+=($!)
for _ in $(seq 100); do
  [ -s "$work/ready.json" ] && break
  kill -0 "${pids[0]}" 2>/dev/null || break
  sleep 0.1
done
if ! [ -s "$work/ready.json" ]; then
  echo "the daemon did not start:" >&2
  cat "$work/styled.log" >&2
  exit 1
fi
endpoint() { sed -n "s/.*\"$1\": *\"\([^\"]*\)\".*/\1/p" "$work/ready.json" | head -1; }
source_at=udp://$(endpoint listen)
publish_at=$(endpoint publish)
control_at=$(endpoint control)

setsid "$bin/stylesim" --to "$source_at" --rate 120 --performers "$performers" \
  >"$work/stylesim.log" 2>&1 &
sim=$!
pids+=("$sim")

control() { "$bin/stylectl" --endpoint "$control_at" "$@"; }
monitor=("$bin/stylemon" --publisher "$publish_at" --control "$control_at")
if [ "$plain" = yes ]; then monitor+=(--plain --every 2000); fi
if [ "$plain" = no ] && [ "$seconds" = 0 ]; then setsid=(); else setsid=(setsid); fi
"${setsid[@]}" "${monitor[@]}" &
mon=$!
pids+=("$mon")

mapfile -t styles < <(control list --json | tr ',{' '\n\n' |
  sed -n 's/.*"name": *"\([^"]*\)".*/\1/p' | grep -v '^neutral$')
begun=$SECONDS
next=0
switches=0
while [ "$stopped" = no ]; do
  kill -0 "$mon" 2>/dev/null || break
  if [ "$seconds" != 0 ] && [ $((SECONDS - begun)) -ge "$seconds" ]; then break; fi
  if [ $((SECONDS - begun)) -ge "$next" ] && [ ${#styles[@]} -gt 0 ]; then
    style=${styles[$((switches % ${#styles[@]}))]}
    control set '*' --style "$style" --transition 400 >"$work/set.log" 2>&1 || true
    switches=$((switches + 1))
    next=$((next + 4))
  fi
  sleep 0.2 || true
done

control status --json >"$work/status.json" 2>/dev/null || true
kill -INT "$sim" 2>/dev/null || true
wait "$sim" 2>/dev/null || true
kill -TERM "$mon" 2>/dev/null || true
wait "$mon" 2>/dev/null || true
echo
tail -n 1 "$work/stylesim.log"
kill -TERM "${pids[0]}" 2>/dev/null || true
code=0
wait "${pids[0]}" || code=$?
echo "styled for $((SECONDS - begun)) s, $switches switches of style among ${#styles[@]} styles;" \
  "the daemon ended with code $code"
[ "$code" = 0 ]
