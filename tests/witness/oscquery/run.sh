#!/usr/bin/env bash
# run.sh PROGRAM: runs PROGRAM (styled_oscquery_witness_test) in a network of two machines, 10.83.0.1 and
# 10.83.0.2, with a D-Bus of its own on which it starts avahi-daemon: the machine's own avahi-daemon, and its
# network, are left alone. $STYLED_FAR runs a command on the second machine, which has no avahi-daemon. In the
# folder that fetch.sh has filled. 77: skipped.
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin
for tool in ip nsenter unshare dbus-daemon avahi-daemon node; do
  command -v $tool >/dev/null || { echo "skipped, no $tool"; exit 77; }
done
[ -d node_modules/oscquery ] || { echo "skipped, no oscquery (npm)"; exit 77; }
if [ "${STYLED_OSCQUERY_STAGE:-}" = "" ]; then
  # avahi-daemon keeps its process id in /run.
  unshare --net --mount mount -t tmpfs tmpfs /run 2>/dev/null ||
    { echo "skipped, no right to make a network and a mount namespace"; exit 77; }
  STYLED_OSCQUERY_STAGE=1 exec unshare --net --mount "$0" "$@"
fi
mount -t tmpfs tmpfs /run
unshare --net sleep 300 &
far=$!
trap 'kill $far' EXIT
for _ in {1..50}; do
  [ "$(readlink /proc/$far/ns/net)" = "$(readlink /proc/self/ns/net)" ] || break
  sleep 0.1
done
export STYLED_FAR="nsenter --net=/proc/$far/ns/net"
ip link add stage type veth peer name far || { echo "skipped, no veth"; exit 77; }
ip link set far netns $far
# @homebridge/ciao does not understand the name of one end of a pair.
$STYLED_FAR ip link add bridge type bridge || { echo "skipped, no bridge"; exit 77; }
$STYLED_FAR ip link set far up master bridge
connect() {  # connect ADDRESS INTERFACE [PREFIX...]
  "${@:3}" ip link set lo up
  "${@:3}" ip address add "$1/24" dev "$2"
  "${@:3}" ip link set "$2" up
  "${@:3}" ip route add 224.0.0.0/4 dev "$2"
}
connect 10.83.0.1 stage
connect 10.83.0.2 bridge $STYLED_FAR
cat >/run/bus.conf <<C
<!DOCTYPE busconfig PUBLIC "-//freedesktop//DTD D-BUS Bus Configuration 1.0//EN"
  "http://www.freedesktop.org/standards/dbus/1.0/busconfig.dtd">
<busconfig>
  <listen>unix:path=/run/bus</listen>
  <policy context="default">
    <allow user="*"/>
    <allow own="*"/>
    <allow send_destination="*"/>
    <allow send_type="method_call"/>
    <allow receive_type="*"/>
  </policy>
</busconfig>
C
printf '[server]\nuse-ipv6=no\n[publish]\npublish-workstation=no\n' >/run/avahi.conf
export DBUS_SYSTEM_BUS_ADDRESS=unix:path=/run/bus
dbus-daemon --config-file=/run/bus.conf --nofork --nopidfile 2>/run/bus.log &
bus=$!
trap 'kill $far $bus' EXIT
for _ in {1..50}; do
  [ ! -S /run/bus ] || break
  sleep 0.1
done
[ -S /run/bus ] || { echo "FAILED: no dbus-daemon"; cat /run/bus.log; exit 1; }
"$1"
