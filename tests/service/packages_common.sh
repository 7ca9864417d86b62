# For packages.sh, upgrade.sh and ../arm64.sh, which source it: a system below $root, with log files in $work; $emulator, if
# set, runs its programs; $during, if set, is a command for the shell there while the daemon runs, whose $1 is the control socket.
failed=0
check() { if [ "$2" = "$3" ]; then echo "ok: $1"; else echo "FAILED: $1: $2, expected $3"; failed=1; fi; }
inside() {
  chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
quietly() { "$@" >"$work/log" 2>&1 || { tail -n 30 "$work/log"; echo "FAILED: $*"; exit 1; }; }
apt() { quietly inside apt-get -q -y --no-install-recommends "$@"; }

# As it is started by hand: ports of the system's choice, and the weights given (none: the default).
setting() { sed -n "s/.*\"$1\": \"\(.*\)\".*/\1/p" "$root/tmp/ready.json" | head -n 1; }
runs() { # STYLE [OPTION...]
  local style=$1 daemon i
  shift
  rm -f "$root/tmp/ready.json"
  chroot "$root" ${emulator:-} /usr/bin/styled --config /etc/styled/styled.toml --set source.0.listen=127.0.0.1:0 --set source.1.listen=127.0.0.1:0 \
    --set publish.address=tcp://127.0.0.1:0 --set control.address=tcp://127.0.0.1:0 \
    --set state.dir=/var/lib/styled --set security.keys=/var/lib/styled/keys --set record.file=/var/lib/styled/ \
    --ready-file /tmp/ready.json "$@" 2>"$work/styled.log" &
  daemon=$!
  for i in $(seq 1200); do [ -s "$root/tmp/ready.json" ] && break; sleep 0.1; done  # an emulator needs half a minute
  [ -s "$root/tmp/ready.json" ] || { cat "$work/styled.log" >&2; kill "$daemon"; return 1; }
  # qemu's emulation of Linux gives stylesim answers of absent programs without end; this machine's sends there.
  if [ -n "${emulator:-}" ]; then
    "$stylesim" --to "udp://$(setting listen)" --seconds 2 >/dev/null
  else
    inside stylesim --to "udp://$(setting listen)" --seconds 2 >/dev/null
  fi
  [ -z "${during:-}" ] || quietly inside sh -ec "$during" sh "$(setting control)"
  [ -z "$style" ] || inside ${emulator:-} /usr/bin/stylectl --endpoint "$(setting control)" set rig.sim --style "$style" >/dev/null
  inside ${emulator:-} /usr/bin/stylectl --endpoint "$(setting control)" status | grep -o "rig.sim.*\(elderly\|zombie\|pirate\)" | grep -o '[a-z]*$' || true
  kill "$daemon"
  wait "$daemon" || { cat "$work/styled.log" >&2; return 1; }
}
# The folder that a daemon makes which others can reach; this one is on loopback.
allow() { quietly inside sh -c 'mkdir -p -m 700 /var/lib/styled/keys; stylectl --keys /var/lib/styled/keys allow anna -- "$(stylectl keygen /tmp/anna.key | grep -o "[^ ]\{40\}")"'; }
# To make a style of an example: during=$like runs STYLE "${library[@]}". The clip is put into /tmp/pirate.bvh.
like='stylectl --endpoint "$1" like rig.sim --clip /tmp/pirate.bvh --name pirate'
library=(--set style.library=/var/lib/styled/styles)
