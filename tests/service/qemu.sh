#!/usr/bin/env bash
# The installed packages under a real systemd: readiness, reload, watchdog, restart, sandbox, USB, journal.
# A virtual machine without KVM, by hand, a few minutes.
#   tests/service/qemu.sh BUILD ROOT KERNEL MODULES
#     BUILD    a build folder: bin/styled_freeze is taken from it
#     ROOT     a system with the packages in it, as tests/service/packages.sh leaves it; not changed
#     KERNEL   Debian's vmlinuz, MODULES its lib/modules/VERSION (package linux-image-amd64)
# apt: qemu-system-x86 busybox-static cpio kmod
set -euo pipefail
[ $# -eq 4 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
build=$(realpath "$1") root=$(realpath "$2") kernel=$(realpath "$3") modules=$(realpath "$4")
version=$(basename "$modules")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
first=$work/first  # the initramfs: it puts a tmpfs over ROOT and continues there
mkdir -p "$first"/{bin,dev,proc,sys,lower,upper,new,try,lib/modules/"$version"}
cp "$(command -v busybox)" "$first/bin/busybox"
for folder in drivers/virtio drivers/usb/common drivers/usb/core drivers/usb/gadget drivers/hid fs/9p fs/netfs fs/fscache \
  fs/overlayfs fs/configfs net/9p; do
  [ -d "$modules/kernel/$folder" ] || continue
  mkdir -p "$first/lib/modules/$version/kernel/$folder"
  cp -r "$modules/kernel/$folder/." "$first/lib/modules/$version/kernel/$folder"
done
cp "$modules"/modules.{builtin,order} "$first/lib/modules/$version/"
depmod -b "$first" "$version" 2>/dev/null
cp "$build/bin/styled_freeze" "$here/in_guest.sh" "$first/try/"
cat >"$first/try/try.service" <<'UNIT'
[Unit]
Requires=basic.target
After=basic.target systemd-udev-settle.service
[Service]
ExecStart=/bin/sh -c '/try/in_guest.sh >/dev/ttyS0 2>&1; systemctl poweroff -ff'
UNIT
cat >"$first/init" <<'INIT'
#!/bin/busybox sh
/bin/busybox --install -s /bin
export PATH=/bin
mount -t proc proc /proc; mount -t sysfs sysfs /sys; mount -t devtmpfs dev /dev
for module in virtio_pci 9pnet_virtio 9p overlay configfs usbhid hid-generic libcomposite usb_f_hid; do modprobe $module; done
modprobe dummy_hcd num=1
mount -t 9p -o trans=virtio,version=9p2000.L,msize=262144,cache=loose,ro root /lower
mount -t tmpfs -o mode=755 upper /upper
mkdir /upper/data /upper/work
mount -t overlay -o lowerdir=/lower,upperdir=/upper/data,workdir=/upper/work overlay /new
cp -r /try /new/try
cp /try/try.service /new/etc/systemd/system/
umount /proc /sys; mount --move /dev /new/dev
exec switch_root /new /lib/systemd/systemd
INIT
chmod +x "$first/init"
(cd "$first" && find . | cpio -o -H newc --quiet | gzip -1) >"$work/initramfs.gz"
timeout 1800 qemu-system-x86_64 -accel tcg -cpu max -smp 2 -m 2048 -nographic -no-reboot -nodefaults \
  -serial stdio -kernel "$kernel" -initrd "$work/initramfs.gz" \
  -virtfs "local,path=$root,mount_tag=root,security_model=passthrough,readonly=on,multidevs=remap" \
  -append "console=ttyS0 quiet loglevel=3 panic=-1 systemd.unit=try.service systemd.show_status=no" | tee "$work/log"
grep -q "qemu: all passed" "$work/log"
