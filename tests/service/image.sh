#!/usr/bin/env bash
# Runs the container image of systemd/image.sh as its user, with a read-only root, without a capability and without a network
# but its own loopback. By hand, as root, half a minute.
#   tests/service/image.sh ARCHIVE
# apt: umoci runc jq
set -euo pipefail
[ $# -eq 1 ] || { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2; }
archive=$(realpath "$1")
work=$(mktemp -d)
name=styled-test-$$
cleanup() {
  runc delete --force "$name" >/dev/null 2>&1 || true
  rm -rf --one-file-system "$work"
}
trap cleanup EXIT
failed=0
check() { if [ "$2" = "$3" ]; then echo "ok: $1"; else echo "FAILED: $1: $2, expected $3"; failed=1; fi; }
mkdir "$work/oci"
tar -xf "$archive" -C "$work/oci"
tag=$(jq -r '.manifests[0].annotations["org.opencontainers.image.ref.name"]' "$work/oci/index.json")
umoci unpack --image "$work/oci:$tag" "$work/bundle" >"$work/log" 2>&1 || { cat "$work/log"; exit 1; }
check "the user is not root" "$(jq -c .process.user "$work/bundle/config.json")" '{"uid":7000,"gid":7000}'
check "it keeps the builder's packages outside" "$(ls "$work/bundle/rootfs" | grep -c apt)" 0
# Volumes: the state is a folder of that user, the configuration is the image's.
install -d -o 7000 -g 7000 "$work/state"
jq --arg state "$work/state" '.root.readonly = true | .process.terminal = false | .process.noNewPrivileges = true
  | .process.capabilities = {} | .process.args += ["--weights", "open"]
  | .mounts |= map(select(.destination != "/etc/styled" and .destination != "/var/lib/styled" and .destination != "/sys/fs/cgroup"))
  | .mounts += [{destination: "/var/lib/styled", type: "bind", source: $state, options: ["rbind", "rw"]}]' \
  "$work/bundle/config.json" >"$work/config.json"
mv "$work/config.json" "$work/bundle/config.json"
runc run --no-pivot --bundle "$work/bundle" "$name" >"$work/styled.log" 2>&1 &
daemon=$!
for _ in $(seq 300); do grep -q ' ready: ' "$work/styled.log" && break; sleep 0.1; done
grep -q ' ready: ' "$work/styled.log" || { cat "$work/styled.log"; echo "FAILED: it does not start"; exit 1; }
inside() { runc exec "$name" "$@"; }
check "nothing can be written beside the state" "$(inside sh -c 'touch /usr/x /etc/x /x 2>&1 | grep -c Read-only; id -u')" "$(printf '3\n7000')"
inside stylesim --seconds 4 >/dev/null 2>&1 &
sleep 1
inside stylectl set rig.sim --style zombie >/dev/null
check "a styled performer" "$(inside stylectl status | grep -c 'rig.sim.*zombie')" 1
check "and their frames" "$(inside stylemon --plain --seconds 2 | grep -q rig.sim && echo seen)" seen
runc kill "$name" TERM
wait "$daemon" && code=0 || code=$?
check "it ends by SIGTERM" "$code" 0
check "the state is kept" "$(grep -c zombie "$work/state/performers.toml")" 1
[ $failed = 0 ] && echo "image: all passed" || { echo "image: FAILED"; exit 1; }
