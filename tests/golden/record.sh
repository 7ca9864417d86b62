#!/usr/bin/env bash
# record.sh BUILD [NAME...]: makes golden recordings and their expected outputs again: all of
# recordings.txt, or those NAMEd. BUILD's daemon records ([record]) each rig's stand-in for two
# seconds, styled from the second one on. Needs minutes on an idle machine, and ports 27000-27003.
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
bin=$(realpath "$1")/bin
shift
script=walk:1,wave-left:1,turn-left:1,run:2  # kScript in golden.h
work=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$work"' EXIT
mkdir -p "$here"/{recordings,expected}
cd "$work"

record() {  # NAME TYPE AS RATE SECONDS PERFORMERS QUIRKS FAULTS
  rm -f take.styrec ready.json
  case $2 in usb | slimevr-usb)
    "$bin/styled_golden_usb" "$2" "$5"
    "$bin/styled_golden_write" take.styrec "$1"
    return ;;
  esac
  local to=udp://127.0.0.1:27000 keys='listen = "127.0.0.1:27000"' quirks=() faults=$8
  case $2 in
    tcp | mvn-tcp) to=tcp://127.0.0.1:27000 ;;
    natnet) to=udp://127.0.0.1:27003 keys='server = "127.0.0.1:27003"'
      [[ $7 != *2.9* ]] || keys+=$'\nmulticast = false'
      [[ $7 != *z-up* ]] || keys+=$'\nup = "z"' ;;
    qtm) to=tcp://127.0.0.1:27003 keys='server = "127.0.0.1:27003"' ;;
  esac
  [ "$7" = - ] || IFS=, read -ra quirks <<<"--quirk,$7"
  [ "$faults" != - ] || faults=
  cat >styled.toml <<TOML
[[source]]
name = "suit"
type = "$2"
$keys
[publish]
address = "tcp://127.0.0.1:27001"
[control]
address = "tcp://127.0.0.1:27002"
[performers]
backlog_ms = 10000
[record]
file = "take.styrec"
TOML
  "$bin/styled" --config styled.toml --ready-file ready.json 2>styled.log &
  local daemon=$!
  until [ -s ready.json ]; do sleep 0.05; kill -0 $daemon; done
  "$bin/stylesim" --as "$3" --to "$to" --rate "$4" --performers "$6" --seconds "$5" \
    --script "$script" --faults "$faults" "${quirks[@]}" >sim.log &
  local sim=$!
  sleep $(($5 - 1))
  "$bin/stylectl" --endpoint tcp://127.0.0.1:27002 set '*' --style elderly --transition 200 >/dev/null
  wait $sim
  sleep 0.1
  kill -TERM $daemon
  wait $daemon
  "$bin/styled_golden_write" take.styrec "$1"
}

while read -r name rest; do
  [[ -n $name && $name != \#* ]] || continue
  [[ $# -eq 0 || " $* " == *" $name "* ]] || continue
  # shellcheck disable=SC2086
  record "$name" $rest
done <"$here/recordings.txt"
du -sh "$here"
