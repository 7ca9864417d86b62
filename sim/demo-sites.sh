#!/usr/bin/env bash
# Builds Styled and shows two sites and a viewer on this machine, with Debian's nats-server: each site
# has a daemon, a performer, a stylenats and a leaf server of its own; both are on one hub; the viewer's end
# (stylenats --join) gives the hall's frames to programs here, and sends a style there. Halfway the hub
# is killed and started again. At the end it says what was recorded beside the daemon and at the viewer.
#   --seconds N      record for so long (default 30, at least 15)
#   --no-build       use the binaries that are there (of the folder STYLED_BIN, if that is set)
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/sim/setup.sh"

seconds=30
build=yes
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds)
      if ! [[ "${2:-}" =~ ^[0-9]+$ ]] || [ "$2" -lt 15 ]; then
        echo "--seconds: expected a whole number from 15 on, found '${2:-nothing}'" >&2
        exit 2
      fi
      seconds=$2
      shift
      ;;
    --no-build) build=no ;;
    -h | --help) sed -n '2,8s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) echo "unknown option '$1'; see --help" >&2; exit 2 ;;
  esac
  shift
done

if [ "$build" = yes ]; then
  styled_install sites
  echo "building (the first time takes a few minutes; log in build/release.log)"
  styled_targets="styled_demo stylenats stylerec" styled_build release -DSTYLED_TESTS=OFF -DSTYLED_TRAIN=OFF
fi
bin=${STYLED_BIN:-$root/build/release/bin}
for program in styled stylesim stylectl stylenats stylerec; do
  [ -x "$bin/$program" ] || { echo "$bin/$program is missing: run without --no-build" >&2; exit 1; }
done
nats_server=$(command -v nats-server || echo /usr/sbin/nats-server)
[ -x "$nats_server" ] || { echo "nats-server is missing: apt install nats-server" >&2; exit 1; }

work=$(mktemp -d)
pids=()
stop() {
  trap - EXIT INT TERM
  for pid in "${pids[@]}"; do kill -TERM "$pid" 2>/dev/null || true; done
  for pid in "${pids[@]}"; do wait "$pid" 2>/dev/null || true; done
  rm -rf "$work"
}
trap stop EXIT
trap 'exit 130' INT TERM
fail() {
  echo "$1" >&2
  cat "$2" >&2
  exit 1
}

# The next ports on which nobody listens; others may take them until they are used, on a busy machine.
port=7300
next_port() {
  port=$((port + 1))
  while (: <"/dev/tcp/127.0.0.1/$port") 2>/dev/null; do port=$((port + 1)); done
}
# started NAME COMMAND...: in a process group of its own, so that Ctrl-C reaches this script alone.
started() {
  local name=$1
  shift
  setsid "$@" >"$work/$name.log" 2>&1 &
  pids+=($!)
}
wait_for() { # wait_for TEXT LOG
  for _ in $(seq 150); do
    grep -q "$1" "$work/$2.log" 2>/dev/null && return
    sleep 0.1
  done
  fail "$2: waited in vain for '$1'" "$work/$2.log"
}

# The shipped configurations, on free ports and with passwords of this run.
for role in BRIDGE LEAF OPERATOR VIEWER GUEST; do
  export "STYLED_NATS_$role=p$(od -An -N8 -tx8 /dev/urandom | tr -d ' ')"
done
next_port; hub_port=$port
next_port; hub_leafs=$port
sed "s|listen: 127.0.0.1:4223|listen: 127.0.0.1:$hub_port|; s|listen: 127.0.0.1:7422|listen: 127.0.0.1:$hub_leafs|
  s|/var/lib/nats/styled|$work/jetstream|" "$root/systemd/nats/hub.conf" >"$work/hub.conf"
export STYLED_NATS_HUB="nats://leaf:$STYLED_NATS_LEAF@127.0.0.1:$hub_leafs"
login() { # login USER: the file that --nats-login wants
  local role=STYLED_NATS_${1^^}
  (umask 077 && printf '%s\n%s\n' "$1" "${!role}" >"$work/$1.login")
}
login bridge
login operator
started hub "$nats_server" -c "$work/hub.conf"
hub=${pids[-1]}
wait_for "Server is ready" hub

start_site() { # start_site SITE PERFORMER: sets publish_at
  local site=$1
  next_port
  sed "s|listen: 127.0.0.1:4222|listen: 127.0.0.1:$port|; s|server_name: styled_leaf|server_name: leaf_$site|" \
    "$root/systemd/nats/leaf.conf" >"$work/leaf-$site.conf"
  local leaf_port=$port
  started "leaf-$site" "$nats_server" -c "$work/leaf-$site.conf"
  wait_for "Leafnode connection created" "leaf-$site"
  printf '[[source]]\nname = "%s"\ntype = "udp"\nlisten = "127.0.0.1:0"\n[publish]\naddress = "tcp://127.0.0.1:0"\n[control]\naddress = "tcp://127.0.0.1:0"\n' \
    "$site" >"$work/$site.toml"
  started "$site" "$bin/styled" --config "$work/$site.toml" --ready-file "$work/$site.json"
  wait_for " ready: " "$site"
  value() { sed -n "s/.*\"$1\": *\"\([^\"]*\)\".*/\1/p" "$work/$site.json" | head -1; }
  publish_at=$(value publish)
  started "$site-rig" "$bin/stylesim" --to "udp://$(value listen)" --rate 120 --performer "$2"
  started "$site-bridge" "$bin/stylenats" --site "$site" --domain hub --publish "$publish_at" \
    --control "$(value control)" --nats "nats://127.0.0.1:$leaf_port" --nats-login "$work/bridge.login"
  wait_for "subscribed to" "$site-bridge"
}
start_site studio ben
start_site hall anna
echo "sites: hall (hall.anna) and studio (studio.ben), each behind a leaf server; hub at nats://127.0.0.1:$hub_port"

next_port; viewer_at=tcp://127.0.0.1:$port
next_port; viewer_control=tcp://127.0.0.1:$port
started viewer "$bin/stylenats" --join --site hall --nats "nats://127.0.0.1:$hub_port" \
  --nats-login "$work/operator.login" --publish "$viewer_at" --control "$viewer_control"
wait_for "connected to" viewer
for _ in $(seq 100); do
  "$bin/stylectl" --endpoint "$viewer_control" set hall.anna --style elderly >"$work/set.log" 2>&1 && break
  sleep 0.1
done
grep -q "from frame" "$work/set.log" || fail "the viewer's command had no effect" "$work/set.log"
echo "viewer of the hall: $viewer_at; its command: $(cat "$work/set.log")"

topic=styled/hall.anna/rig/
for what in "beside-the-daemon $publish_at" "at-the-viewer $viewer_at"; do
  read -r name from <<<"$what"
  started "$name" "$bin/stylerec" record --from "$from" --topics "$topic,body/" --seconds "$seconds" "$work/$name.styrec"
  recorders="${recorders:-} ${pids[-1]}"
done
sleep $((seconds / 2))
echo "the hub is killed (kill -9), and started again after 2 s"
kill -9 "$hub"
wait "$hub" 2>/dev/null || true
sleep 2
started hub-again "$nats_server" -c "$work/hub.conf"
for pid in $recorders; do wait "$pid" || true; done
for name in beside-the-daemon at-the-viewer; do
  [ -s "$work/$name.styrec" ] || fail "$name: nothing was recorded" "$work/$name.log"
done
frames_of() { "$bin/stylerec" info "$work/$1.styrec" | sed -n "s|^published: $topic \([0-9]*\) messages.*|\1|p"; }
here=$(frames_of beside-the-daemon)
there=$(frames_of at-the-viewer)
echo "beside the daemon: ${here:-0} frames in $seconds s"
echo "at the viewer: ${there:-0}; $(((here - there) * 1000 / 120)) ms are missing, of which the hub was away 2000"
# A viewer whose frames never come again has at most half of them.
[ "${there:-0}" -gt $((here * 3 / 5)) ]
