#!/usr/bin/env bash
# run.sh PROGRAM: the output of PROGRAM (styled_clock_print) for a real ptp4l must agree with that of pmc. 77:
# skipped.
set -euo pipefail
for tool in ptp4l pmc ip unshare; do
  PATH=$PATH:/usr/sbin:/sbin command -v $tool >/dev/null || { echo "skipped, no $tool"; exit 77; }
done
if [ "${STYLED_PTP_STAGE:-}" = "" ]; then
  unshare -n true 2>/dev/null || { echo "skipped, no right to make a network namespace"; exit 77; }
  STYLED_PTP_STAGE=1 exec unshare -n "$0" "$@"
fi
PATH=$PATH:/usr/sbin:/sbin
folder=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null || true; rm -rf "$folder"' EXIT
ip link add leader type veth peer name follower || { echo "skipped, no veth"; exit 77; }
ip link set leader up
ip link set follower up
for name in leader follower; do
  # The clock of this machine is left alone.
  cat >"$folder/$name.conf" <<C
[global]
domainNumber 127
time_stamping software
network_transport L2
free_running 1
clock_servo nullf
priority1 $([ $name = leader ] && echo 100 || echo 200)
logSyncInterval -3
logAnnounceInterval -2
uds_address $folder/$name
[$name]
C
  ptp4l -f "$folder/$name.conf" -m >"$folder/$name.log" 2>&1 &
done
ask() { pmc -u -b 0 -d 127 -s "$folder/follower" -i "$folder/pmc" "GET $1" 2>/dev/null | awk -v name="$2" '$1 == name { print $2 }'; }
for _ in {1..40}; do
  # The path's delay is measured last.
  [[ $(ask CURRENT_DATA_SET stepsRemoved) != 1 || $(ask CURRENT_DATA_SET meanPathDelay) == 0.0 ]] || break
  sleep 0.5
done
said=$("$1" "$folder/follower") || { echo "FAILED: nothing found out"; cat "$folder"/*.log; exit 1; }
echo "$said"
failed=0
same() {
  local ours theirs
  ours=$(awk -v name="$1" '$1 == name { print $2 }' <<<"$said")
  theirs=$(ask "$2" "$3")
  [ "$ours" = "$theirs" ] || { echo "FAILED: $1 is $ours, pmc says $theirs"; failed=1; }
}
same leader PARENT_DATA_SET grandmasterIdentity
same priority1 PARENT_DATA_SET grandmasterPriority1
same class PARENT_DATA_SET gm.ClockClass
same port PORT_DATA_SET portState
same steps CURRENT_DATA_SET stepsRemoved
same source TIME_PROPERTIES_DATA_SET timeSource
grep -qx 'domain 127' <<<"$said" || { echo "FAILED: expected domain 127"; failed=1; }
# Between two processes of one machine a packet takes less than a second.
awk '$1 == "delay_ns" { exit !($2 > 0 && $2 < 1e9) }' <<<"$said" || { echo "FAILED: delay"; failed=1; }
exit $failed
