#!/usr/bin/env bash
# The unmodified daemon on USB devices that the kernel itself drives: a virtual machine whose gadgets
# (a HID one as SlimeVR's receiver, a vendor one with our own records) are plugged into its own
# dummy_hcd. By hand, a few minutes; needs neither root nor KVM.
#   tests/usb/qemu.sh BUILD KERNEL MODULES
#     BUILD    a build folder: bin/styled, bin/stylectl, bin/stylesim are taken from it
#     KERNEL   Debian's vmlinuz, MODULES its lib/modules/VERSION (package linux-image-amd64)
# apt: qemu-system-x86 busybox-static cpio kmod udev
set -euo pipefail
[ $# -eq 3 ] || { sed -n '2,9s/^# \{0,1\}//p' "$0" >&2; exit 2; }
root=$(cd "$(dirname "$0")/../.." && pwd)
build=$(realpath "$1") kernel=$(realpath "$2") modules=$(realpath "$3")
version=$(basename "$modules")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
guest=$work/guest

copy() {  # PROGRAM PATH: with its libraries
  mkdir -p "$guest$(dirname "$2")"
  cp -L "$1" "$guest$2"
  { ldd "$1" 2>/dev/null | grep -o '/[^ )]*' || true; } | while read -r library; do
    mkdir -p "$guest$(dirname "$library")"
    cp -nL "$library" "$guest$library"
  done
}
mkdir -p "$guest"/{bin,dev,proc,sys,run,tmp,etc,ffs,sbin,lib/modules/"$version"/kernel,usr/lib/udev/rules.d}
for program in styled stylectl stylesim; do copy "$build/bin/$program" "/bin/$program"; done
copy "$(command -v busybox)" /bin/busybox
copy /lib/systemd/systemd-udevd /lib/systemd/systemd-udevd
copy "$(command -v udevadm)" /bin/udevadm
cp /usr/lib/udev/rules.d/50-udev-default.rules "$root/systemd/70-styled.rules" "$guest/usr/lib/udev/rules.d/"
cp "$(ls "$root"/model/weights/*.safetensors | tail -n 1)" "$guest/etc/weights.safetensors"
for folder in drivers/usb/{common,core,gadget} drivers/hid fs/configfs; do
  mkdir -p "$guest/lib/modules/$version/kernel/$folder"
  cp -r "$modules/kernel/$folder/." "$guest/lib/modules/$version/kernel/$folder"
done
cp "$modules"/modules.{builtin,order} "$guest/lib/modules/$version/"
depmod -b "$guest" "$version" 2>/dev/null
printf 'root:x:0:0::/:/bin/sh\n' >"$guest/etc/passwd"
printf 'root:x:0:\nstyled:x:990:\n' >"$guest/etc/group"

cat >"$guest/etc/styled.toml" <<'TOML'
[[source]]
name = "dongle"
type = "slimevr-usb"
rate_hz = 10                # a virtual machine without KVM is slow
trackers = { "010203040506" = "hips", "010203040507" = "head" }
[[source]]
name = "suit"
type = "usb"
usb_id = "1234:0001"
[performers]
stale_ms = 10000
backlog_ms = 10000
TOML

cat >"$guest/init" <<'INIT'
#!/bin/busybox sh
/bin/busybox --install -s /bin
export PATH=/bin
mount -t proc proc /proc; mount -t sysfs sysfs /sys; mount -t devtmpfs dev /dev; mount -t tmpfs run /run
ip link set lo up
/lib/systemd/systemd-udevd --daemon
modprobe configfs; mount -t configfs config /sys/kernel/config
modprobe usbhid; modprobe hid-generic; modprobe libcomposite; modprobe usb_f_hid; modprobe usb_f_fs
modprobe dummy_hcd num=2
failed=0
check() { if [ "$2" = "$3" ]; then echo "ok: $1"; else echo "FAILED: $1: $2, expected $3"; failed=1; fi; }
soon() {  # COMMAND VALUE: what the command prints, once it is that, or after 30 s
  for i in $(seq 150); do [ "$(eval "$1")" = "$2" ] && break; sleep 0.2; done
  eval "$1"
}
counter() { stylectl status --all | awk -v name="$1" '$1 == name { print $2 }'; }
received() {  # SOURCE: how much it got
  stylectl status --json | tr -d ' \n' | grep -o "{[^{}]*\"name\":\"$1\"[^{}]*}" | sed 's/.*"received":\([0-9]*\).*/\1/'
}
lost() { stylectl status | awk -v name="$1" '$1 == name { print $8 }'; }
opened() { grep -c ": opened" /styled.log; }
gadget() {  # NAME VENDOR PRODUCT FUNCTION
  g=/sys/kernel/config/usb_gadget/$1
  mkdir -p $g/strings/0x409 $g/configs/c.1 $g/functions/$4
  echo $2 >$g/idVendor; echo $3 >$g/idProduct; echo "$1-1" >$g/strings/0x409/serialnumber
}
plug() { echo "$2" >/sys/kernel/config/usb_gadget/$1/UDC; }
unplug() { echo "" >/sys/kernel/config/usb_gadget/$1/UDC; }
kernel_has() { ls -d /sys/bus/hid/drivers/hid-generic/0* 2>/dev/null | wc -l; }
group() {  # PRODUCT: group and mode of its device
  for d in /sys/bus/usb/devices/*; do
    [ "$(cat $d/idProduct 2>/dev/null)" = "$1" ] && stat -c '%G %a' /dev/$(udevadm info -q name $d)
  done
}

gadget receiver 0x1209 0x7690 hid.0
echo 64 >$g/functions/hid.0/report_length
printf '\x05\x01\x09\x00\xa1\x01\x15\x00\x26\xff\x00\x75\x08\x95\x40\x09\x00\x81\x02\x09\x00\x91\x02\xc0' \
  >$g/functions/hid.0/report_desc
ln -s $g/functions/hid.0 $g/configs/c.1/
plug receiver dummy_udc.0

# FunctionFS: version 2, full and high speed; an interface of class FF, subclass 'S', protocol 1 with
# one bulk IN endpoint. No strings.
gadget suit 0x1234 0x0001 ffs.suit
mount -t functionfs suit /ffs
exec 3<>/ffs/ep0
interface='\x09\x04\x00\x00\x01\xff\x53\x01\x00'
printf "\x03\0\0\0\x34\0\0\0\x03\0\0\0\x02\0\0\0\x02\0\0\0$interface\x07\x05\x81\x02\x40\0\0$interface\x07\x05\x81\x02\0\x02\0" >&3
printf '\x02\0\0\0\x10\0\0\0\0\0\0\0\0\0\0\0' >&3
ln -s $g/functions/ffs.suit $g/configs/c.1/
plug suit dummy_udc.1
check "hid-generic has the receiver before the daemon" "$(soon kernel_has 1)" 1
check "the udev rules give the receiver to the group" "$(soon 'group 7690' 'styled 660')" "styled 660"
check "and the suit, by its interface" "$(soon 'group 0001' 'styled 660')" "styled 660"

styled --config /etc/styled.toml --weights /etc/weights.safetensors 2>/styled.log &
daemon=$!
check "both devices are opened" "$(soon opened 2)" 2
check "the kernel's driver stepped aside" "$(kernel_has)" 0

# Two trackers, upright, and their registrations: what a receiver sends.
printf '\x01\x00\x82\x5a\0\0\0\0\x82\x5a\0\0\0\0\0\0\x01\x01\x82\x5a\0\0\0\0\x82\x5a\0\0\0\0\0\0' >/report
printf '\xff\x00\x06\x05\x04\x03\x02\x01\0\0\0\0\0\0\0\0\xff\x01\x07\x05\x04\x03\x02\x01\0\0\0\0\0\0\0\0' >>/report
for i in $(seq 1000); do cat /report; done >/reports
dd if=/reports of=/dev/hidg0 bs=64 2>/dev/null
check "a thousand reports arrive" "$(soon 'received dongle' 1000)" 1000
check "none is bad" "$(counter usb.bad_reports)" 0
stylectl set dongle.dongle --style elderly >/dev/null
while :; do dd if=/reports of=/dev/hidg0 bs=64 2>/dev/null || sleep 0.1; done &
feeder=$!
check "a skeleton comes out, styled" "$(soon 'stylectl status | grep -c dongle.dongle.*elderly' 1)" 1
stylectl status | grep dongle.dongle
for i in $(seq 20); do
  unplug receiver; sleep 0.3; plug receiver dummy_udc.0
  soon opened $((2 + i)) >/dev/null
done
check "unplugged in mid-transfer and replugged 20 times" "$(counter usb.opened) $(counter usb.lost_devices)" "22 20"
kill $feeder

nc -l -p 7777 >/ffs/ep1 &
stylesim --to tcp://127.0.0.1:7777 --start-wait-ms 5000 --seconds 5 --rate 20 --performer anna | tail -1
check "our own records from the vendor device" "$(soon 'received suit' 105)" 105
check "none of them was lost" "$(lost suit.anna) $(counter usb.bad_reports)" "0 0"
stylectl status | grep suit.anna
kill -TERM $daemon; wait $daemon
check "the daemon ends well" $? 0
check "hid-generic has the receiver again" "$(soon kernel_has 1)" 1
[ $failed = 0 ] && echo "qemu: all passed" || { cat /styled.log; echo "qemu: FAILED"; }
poweroff -f
INIT
chmod +x "$guest/init"
(cd "$guest" && find . | cpio -o -H newc --quiet | gzip -1) >"$work/initramfs.gz"
timeout 900 qemu-system-x86_64 -accel tcg -cpu max -smp 2 -m 1024 -nographic -no-reboot -nodefaults \
  -serial stdio -kernel "$kernel" -initrd "$work/initramfs.gz" \
  -append "console=ttyS0 quiet loglevel=3 panic=-1" | tee "$work/log"
grep -q "qemu: all passed" "$work/log"
