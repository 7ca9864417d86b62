#!/usr/bin/env bash
# The judges of the two sets of Bandai-Namco, five seeds each: one file per set, which every later evaluation can be given
# (--judges). Some 20 minutes a set on one core. The same files, byte for byte, on a machine of the same kind;
# model/weights/RESULTS.md names the SHA-256 of those of its figures.
. "$(dirname "$0")/recipe.sh"

for set in bandai-2 bandai-1; do
  write_judges --manifest "$manifests/$set.toml" --write-judges "$runs/judges-$set.safetensors"
done
[ "$dry_run" = yes ] || sha256sum "$runs"/judges-*.safetensors
