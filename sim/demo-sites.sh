#!/usr/bin/env bash
# Builds Styled and shows two sites and a viewer on this machine, with Debian's nats-server: each site
# has a performer, a daemon, a stylenats and a leaf server of its own; the hall also has a standby
# daemon with a stylenats; both sites are on one hub. The viewer's end (stylenats --join) provides the
# hall's frames to programs here, and sends a style there. After a third of the time the hall's leading
# daemon is killed, after two thirds the hub, which is then restarted. At the end it reports the frames
# that were recorded beside the daemons and at the viewer.
#   --seconds N      recording time (default 30, at least 15)
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
    -h | --help) sed -n '2,11s/^# \{0,1\}//p' "$0"; exit 0 ;;
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

# The next ports on which no program listens; on a busy machine other programs may take them before
# they are used.
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
for role in BRIDGE LEAF OPERATOR VIEWER RECORDER GUEST; do
  export "STYLED_NATS_$role=p$(od -An -N8 -tx8 /dev/urandom | tr -d ' ')"
done
next_port; hub_port=$port
next_port; hub_leafs=$port
sed "s|listen: 127.0.0.1:4223|listen: 127.0.0.1:$hub_port|; s|listen: 127.0.0.1:7422|listen: 127.0.0.1:$hub_leafs|
  s|/var/lib/nats/styled|$work/jetstream|" "$root/systemd/nats/hub.conf" >"$work/hub.conf"
export STYLED_NATS_HUB="nats://leaf:$STYLED_NATS_LEAF@127.0.0.1:$hub_leafs"
login() { # login USER: the file for --nats-login
  local role=STYLED_NATS_${1^^}
  (umask 077 && printf '%s\n%s\n' "$1" "${!role}" >"$work/$1.login")
}
login bridge
login operator
started hub "$nats_server" -c "$work/hub.conf"
hub=${pids[-1]}
wait_for "Server is ready" hub

start_leaf() { # start_leaf SITE: sets leaf_port
  next_port
  sed "s|listen: 127.0.0.1:4222|listen: 127.0.0.1:$port|; s|server_name: styled_leaf|server_name: leaf_$1|" \
    "$root/systemd/nats/leaf.conf" >"$work/leaf-$1.conf"
  leaf_port=$port
  started "leaf-$1" "$nats_server" -c "$work/leaf-$1.conf"
  wait_for "Leafnode connection created" "leaf-$1"
}
# start_daemon NAME SITE [CONFIGURATION]: sets publish_at, control_at, listens_at and daemon, beside a bridge
start_daemon() {
  printf '[[source]]\nname = "%s"\ntype = "udp"\nlisten = "127.0.0.1:0"\n[publish]\naddress = "tcp://127.0.0.1:0"\n[control]\naddress = "tcp://127.0.0.1:0"\n%s' \
    "$2" "${3:-}" >"$work/$1.toml"
  started "$1" "$bin/styled" --config "$work/$1.toml" --ready-file "$work/$1.json"
  daemon=${pids[-1]}
  wait_for " ready: " "$1"
  value() { sed -n "s/.*\"$2\": *\"\([^\"]*\)\".*/\1/p" "$work/$1.json" | head -1; }
  publish_at=$(value "$1" publish)
  control_at=$(value "$1" control)
  listens_at=$(value "$1" listen)
  started "$1-bridge" "$bin/stylenats" --site "$2" --domain hub --publish "$publish_at" \
    --control "$control_at" --nats "nats://127.0.0.1:$leaf_port" --nats-login "$work/bridge.login"
  wait_for "subscribed to" "$1-bridge"
}
stands_in() { # stands_in OWN PEER FIRST: the [standby] of one of the hall's two daemons
  printf '[standby]\naddress = "ipc://%s/%s.journal"\npeer = "ipc://%s/%s.journal"\nfirst = %s\n' \
    "$work" "$1" "$work" "$2" "$3"
}
start_leaf studio
start_daemon studio studio
started studio-rig "$bin/stylesim" --to "udp://$listens_at" --rate 120 --performer ben
start_leaf hall
start_daemon hall hall "$(stands_in hall hall-2 true)"
leader=$daemon leader_at=$publish_at leader_control=$control_at hall_rig=$listens_at
start_daemon hall-2 hall "$(stands_in hall-2 hall false)"
started hall-rig "$bin/stylesim" --to "udp://$hall_rig" --to "udp://$listens_at" --rate 120 --performer anna
for _ in $(seq 100); do
  "$bin/stylectl" stages "$leader_control" "$control_at" >"$work/stages.log" 2>&1 || true
  grep -q "following.*ready" "$work/stages.log" && break
  sleep 0.1
done
grep -q "following.*ready" "$work/stages.log" || fail "the hall's second daemon does not follow" "$work/stages.log"
cat "$work/stages.log"
publish_at=$leader_at,$publish_at
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
for what in "beside-the-daemons $publish_at" "at-the-viewer $viewer_at"; do
  read -r name from <<<"$what"
  # shellcheck disable=SC2086  # an option for each address
  started "$name" "$bin/stylerec" record --from ${from//,/ --from } --topics "$topic,body/" --seconds "$seconds" "$work/$name.styrec"
  recorders="${recorders:-} ${pids[-1]}"
done
sleep $((seconds / 3))
echo "the hall's leading daemon is killed (kill -9)"
kill -9 "$leader"
wait "$leader" 2>/dev/null || true
sleep $((seconds / 3))
"$bin/stylectl" stages "$leader_control" "$control_at" || true
echo "the hub is killed (kill -9), and restarted after 2 s"
kill -9 "$hub"
wait "$hub" 2>/dev/null || true
sleep 2
started hub-again "$nats_server" -c "$work/hub.conf"
for pid in $recorders; do wait "$pid" || true; done
for name in beside-the-daemons at-the-viewer; do
  [ -s "$work/$name.styrec" ] || fail "$name: nothing was recorded" "$work/$name.log"
done
frames_of() { "$bin/stylerec" info "$work/$1.styrec" | sed -n "s|^published: $topic \([0-9]*\) messages.*|\1|p"; }
here=$(frames_of beside-the-daemons)
there=$(frames_of at-the-viewer)
echo "beside the daemons: ${here:-0} frames in $seconds s"
echo "at the viewer: ${there:-0}; $(((here - there) * 1000 / 120)) ms are missing, of which the hub was away 2000"
# A viewer whose frames never return has at most two thirds of them.
[ "${there:-0}" -gt $((here * 3 / 4)) ]
