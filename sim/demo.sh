#!/usr/bin/env bash
# Builds Styled and shows it at work: the built-in synthetic performer is streamed at 120 Hz into the
# daemon, the shipped weights restyle it, a tour goes through styles, mixes and parts of the body, and
# the terminal monitor draws input and styled figure side by side. The same is visible in a browser:
# its address is printed; the first time its page is built while the demo runs. Ctrl-C, or q in the
# monitor, ends it.
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
      sed -n '2,10s/^# \{0,1\}//p' "$0"
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
  styled_targets=styled_demo styled_build release -DSTYLED_TESTS=OFF -DSTYLED_TRAIN=OFF
fi
bin=$root/build/release/bin
for program in styled stylesim stylectl stylemon; do
  [ -x "$bin/$program" ] || { echo "$bin/$program is missing: run without --no-build" >&2; exit 1; }
done

work=$(mktemp -d)
pids=()
stop() {
  trap - EXIT INT TERM
  # The viewer's process group: it may be a build.
  [ -z "${web:-}" ] || kill -TERM -- "-$web" 2>/dev/null || true
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

# The view for browsers. Its HTTP code and its page take as long to build as half of the rest, so they
# are built at the lowest priority while the performer is already moving, unless nothing has changed.
port=7080  # the usual one, or the next that is free
while (: <"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do port=$((port + 1)); done
serve_viewer() {
  if [ "$build" = yes ]; then
    nice -n 19 cmake --build "$root/build/release" --target styled_demo_web \
      >"$root/build/release-web.log" 2>&1 || return
  fi
  [ -x "$bin/styleweb" ] && [ -e "$root/build/release/web/index.html" ] || return
  exec "$bin/styleweb" --listen "127.0.0.1:$port" --publish "$publish_at" \
    --control "$control_at" --ready-file "$work/web.json" >"$work/styleweb.log" 2>&1
}
export -f serve_viewer
export build root bin port publish_at control_at work
setsid bash -c serve_viewer &
web=$!
pids+=("$web")
for _ in $(seq 15); do
  [ -s "$work/web.json" ] && break
  kill -0 "$web" 2>/dev/null || break
  sleep 0.1
done
viewer=
if [ -s "$work/web.json" ]; then
  viewer="http://127.0.0.1:$port"
elif kill -0 "$web" 2>/dev/null; then
  viewer="http://127.0.0.1:$port, in some minutes: it is being built (build/release-web.log)"
fi
if [ -n "$viewer" ]; then
  echo "viewer: $viewer"
  [ "$plain" = yes ] || sleep 3  # the monitor is about to take the screen
fi

control() { "$bin/stylectl" --endpoint "$control_at" "$@"; }
monitor=("$bin/stylemon" --publisher "$publish_at" --control "$control_at")
if [ "$plain" = yes ]; then monitor+=(--plain --every 2000); fi
if [ "$plain" = no ] && [ "$seconds" = 0 ]; then setsid=(); else setsid=(setsid); fi
"${setsid[@]}" "${monitor[@]}" &
mon=$!
pids+=("$mon")

mapfile -t styles < <(control list --json | tr ',{' '\n\n' |
  sed -n 's/.*"name": *"\([^"]*\)".*/\1/p' | grep -v '^neutral$')
count=${#styles[@]}
begun=$SECONDS
next=0
switches=0
# One stop of the tour: styles in turn, and after every fourth another feature.
stop_of_tour() {
  local style=${styles[$((switches % count))]} other=${styles[$(((switches + 5) % count))]}
  case $((switches % 8)) in
    4) control set '*' --mix "$style=0.5" --mix "$other=0.5" --strength 1 --transition 1000 ;;
    5) control set '*' --style "$style" --parts arms --transition 600 ;;
    6) control set '*' --style "$style" --parts all --strength 0.5 ;;
    7) control clear '*' ;;
    *) control set '*' --style "$style" --parts all --strength 1 --transition 400 ;;
  esac
}
while [ "$stopped" = no ]; do
  kill -0 "$mon" 2>/dev/null || break
  if [ "$seconds" != 0 ] && [ $((SECONDS - begun)) -ge "$seconds" ]; then break; fi
  if [ $((SECONDS - begun)) -ge "$next" ] && [ ${#styles[@]} -gt 0 ]; then
    stop_of_tour >"$work/set.log" 2>&1 || true
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
echo "styled for $((SECONDS - begun)) s, $switches stops of the tour among $count styles;" \
  "the daemon ended with code $code"
[ "$code" = 0 ]
