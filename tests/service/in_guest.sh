#!/bin/bash
# Runs in the virtual machine, started by qemu.sh.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 SYSTEMD_PAGER=
failed=0
echo "in the guest, after $(cut -d" " -f1 /proc/uptime) s"
check() { if [ "$2" = "$3" ]; then echo "ok: $1"; else echo "FAILED: $1: '$2', expected '$3'"; failed=1; fi; }
holds() { if [ "$2" "$3" "$4" ]; then echo "ok: $1: $2, at most $4"; else echo "FAILED: $1: $2, at most $4"; failed=1; fi; }
soon() {  # COMMAND VALUE: what the command prints, once it is that, or after 30 s
  local end=$(($(now_ms) + 30000)) got
  while got=$(eval "$1" 2>/dev/null); [ "$got" != "$2" ] && [ "$(now_ms)" -lt $end ]; do sleep 0.1; done
  echo "$got"
}
property() { systemctl show "$1" -p "$2" --value; }
main() { property "$1" MainPID; }
now_ms() { awk '{ printf "%d", $1 * 1000 }' /proc/uptime; }
log() { journalctl -u "${1:-styled}" -o cat; }
in_service() { nsenter -t "$(main styled)" -m "$@"; }  # sees what the daemon sees
back() { [ "$(property styled NRestarts)" -gt "$1" ] && property styled ActiveState; }

# A receiver of SlimeVR's, plugged in before there is a daemon.
gadget=/sys/kernel/config/usb_gadget/receiver
mkdir -p $gadget/strings/0x409 $gadget/configs/c.1 $gadget/functions/hid.0
echo 0x1209 >$gadget/idVendor; echo 0x7690 >$gadget/idProduct; echo 64 >$gadget/functions/hid.0/report_length
printf '\x05\x01\x09\x00\xa1\x01\x15\x00\x26\xff\x00\x75\x08\x95\x40\x09\x00\x81\x02\x09\x00\x91\x02\xc0' \
  >$gadget/functions/hid.0/report_desc
ln -s $gadget/functions/hid.0 $gadget/configs/c.1/
echo dummy_udc.0 >$gadget/UDC

cat >>/etc/styled/styled.toml <<'TOML'
[[source]]
name = "dongle"
type = "slimevr-usb"
TOML
sed -i 's/^# priority = 0 /priority = 10 /' /etc/styled/styled.toml

touch /root/secret /home/secret
begun=$(now_ms)
check "systemctl start returns" "$(systemctl start styled; echo $?)" 0
start_ms=$(($(now_ms) - begun))  # emulated, and perhaps on a busy machine: what a start takes here
check "once it is ready" "$(property styled ActiveState) $(log | grep -c 'info\|ready: weights v2')" "active 1"
check "it says how it goes" "$(soon 'property styled StatusText | grep -c "^0 performers, 0 frames/s; publishing on tcp"' 1)" 1
pid=$(main styled)
uid=$(stat -c %u /proc/"$pid")
check "as a user that systemd made up, group styled" \
  "$([ "$uid" -ge 61184 ] && [ "$uid" -le 65519 ] && echo dynamic) $(stat -c %G /proc/"$pid")" "dynamic styled"
check "without rights, new ones or namespaces" \
  "$(awk '/^(CapEff|CapBnd|NoNewPrivs|Seccomp):/ { printf "%s ", $2 }' /proc/"$pid"/status)" \
  "0000000000000000 0000000000000000 1 2 "
for task in /proc/"$pid"/task/*; do [ "$(cat "$task/comm")" = pipeline ] && pipeline=$(basename "$task"); done
check "SCHED_FIFO" "$(chrt -p "$pipeline" | sed 's/.*: //' | paste -sd' ')" "SCHED_FIFO 10"
check "memory is locked" "$([ "$(awk '/^VmLck:/ { print $2 }' /proc/"$pid"/status)" -gt 10000 ] && echo yes)" yes
check "no complaint about either" "$(log | grep -c 'SCHED_FIFO\|not locked')" 0
check "the USB receiver is opened" "$(soon 'log | grep -c ": opened"' 1)" 1

check "the system is read-only for it" "$(in_service touch /usr/x 2>&1 | grep -c 'Read-only')" 1
secrets='ls -A /root /home | grep -c secret'
check "homes are not there" "$(eval "$secrets") $(in_service sh -c "$secrets")" "2 0"
check "its folder it can write" "$(in_service touch /var/lib/styled/x && ls /var/lib/private/styled)" x

entry=$(journalctl -u styled -o json --grep "ready: weights" | tail -n 1)
for field in '"PRIORITY":"6"' '"SYSLOG_IDENTIFIER":"styled"' '"STYLED_VERSION":' '"_TRANSPORT":"journal"'; do
  check "journal: $field" "$(grep -c "$field" <<<"$entry")" 1
done
echo hello >/dev/udp/127.0.0.1/7000
check "trouble can be searched by its counter" \
  "$(soon 'journalctl -u styled STYLED_COUNTER=source.too_short -p warning -o cat | wc -l' 1)" 1

stylesim --seconds 3 --rate 30 >/dev/null
stylectl set rig.sim --style elderly >/dev/null
check "settings are kept" "$(soon 'grep -c elderly /var/lib/styled/performers.toml' 1)" 1

systemctl reload styled || journalctl -u styled -n 5 -o cat
check "a reload" "$(soon 'log | grep -c "reloaded: weights"' 1) $(property styled ActiveState)" "1 active"
echo 'nonsense = 1' >>/etc/styled/styled.toml
systemctl reload styled
check "a refused one is told" "$(soon 'property styled StatusText | grep -c "the last reload was refused"' 1)" 1
check "and changes nothing" "$(main styled) $(property styled ActiveState)" "$pid active"
sed -i '$d' /etc/styled/styled.toml

/try/styled_freeze "$pid" pipeline >/try/frozen &
until grep -q frozen /try/frozen; do sleep 0.05; done
begun=$(now_ms)
check "a hung pipeline is killed by the watchdog" "$(sleep 8; soon 'log | grep -c "Watchdog timeout"' 1)" 1
at_ms() {  # TEXT: when the journal last had it
  journalctl -u styled -o json --grep "$1" | tail -n 1 | sed 's/.*"__MONOTONIC_TIMESTAMP":"\([0-9]*\)[0-9]\{3\}".*/\1/'
}
holds "ms from hang to kill, WatchdogSec + 1 s" $(($(at_ms 'Watchdog timeout') - begun)) -le 6000
check "and it is ready again" "$(soon 'back 0' active)" active
holds "ms from kill to ready, a start's + 1 s" $(($(at_ms 'Started styled') - $(at_ms 'Watchdog timeout'))) -le $((start_ms + 1000))
journalctl -u styled -o short-monotonic | grep -A12 'Watchdog timeout' | cut -c1-150
check "because of the watchdog" "$(log | grep -c "Failed with result 'watchdog'")" 1
check "settings are restored" "$(soon 'stylectl status --all >/dev/null && log | grep -c "1 performers. settings restored"' 1)" 1

for try in 1 2 3; do
  before=$(property styled NRestarts)
  begun=$(now_ms)
  kill -9 "$(main styled)"
  soon "back $before" active >/dev/null
  took=$(($(now_ms) - begun))
  [ $try = 1 ] || [ $took -gt "$longest" ] && longest=$took
done
check "killed three times in a row, it is there" "$(property styled ActiveState)" active
echo "   ms from kill -9 to ready, the longest: $longest; a start takes $start_ms here"

# A stage of its own beside it.
sed 's/:700\([0-2]\)"/:710\1"/; s/^# address = "tcp/address = "tcp/' /etc/styled/styled.toml | sed '/name = "dongle"/,$d' |
  sed '$d' >/etc/styled/stage.toml
sed -i 's#^address = "tcp://127.0.0.1:7102"#address = "ipc:///run/styled@stage/control"\nipc_mode = "0660"#' /etc/styled/stage.toml
check "a second daemon from the template" "$(systemctl start styled@stage; property styled@stage ActiveState)" active
check "has a state of its own" "$(ls -d /var/lib/private/styled@stage)" "/var/lib/private/styled@stage"
asked_by() {  # GROUP: by a user of that group, over ipc
  setpriv --reuid 65534 --regid "$1" --clear-groups stylectl --endpoint ipc:///run/styled@stage/control list >/dev/null
  echo $?
}
check "its ipc address is open to the group" "$(asked_by styled 2>&1)" 0
check "and to nobody else" "$(asked_by nogroup 2>/dev/null)" 3
check "the gateway" "$(systemctl start styleweb; soon 'python3 -c "import urllib.request as u; print(u.urlopen(\"http://127.0.0.1:7080/healthz\").status)"' 200)" 200
vmc=stylevmc@127.0.0.1:39539
check "VMC out" "$(systemctl start $vmc; sleep 5; property $vmc ActiveState) $(property $vmc NRestarts)" "active 0"
check "neither had to be restarted" "$(property styleweb NRestarts)" 0

echo 'nonsense = 1' >/etc/styled/wrong.toml
systemctl start styled@wrong 2>/dev/null
check "a wrong configuration is not tried again" "$(sleep 2; property styled@wrong NRestarts) $(property styled@wrong StatusText | grep -c nonsense)" "0 1"
begun=$(now_ms)
systemctl stop styled
echo "   ms to stop: $(($(now_ms) - begun))"
check "stopped cleanly" "$(property styled Result) $(log | grep -c 'SIGTERM: stopping')" "success 1"
[ $failed = 0 ] && echo "qemu: all passed" || { journalctl --no-hostname -o short-monotonic | tail -n 80; echo "qemu: FAILED"; }
