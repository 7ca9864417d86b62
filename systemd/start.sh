#!/bin/sh
# Starts libexec/NAME of this folder with the C library that lies beside it, so that it runs wherever the kernel
# does: the system's own may be older than the programs. NAME is this file's, also through links.
here=$(readlink -f "$0") || exit 1
name=${here##*/}
here=${here%/*/*}
if [ -r /proc/cpuinfo ]; then
  for feature in avx2 bmi2 fma; do
    grep -qw "$feature" /proc/cpuinfo && continue
    echo "$name: this processor has no $feature; build from source for it" >&2
    exit 1
  done
fi
# The loader lies in lib/, from where programs find ../share/styled: to them it is /proc/self/exe.
exec "$here/lib/ld-linux-x86-64.so.2" --argv0 "$name" --library-path "$here/lib" "$here/libexec/$name" "$@"
