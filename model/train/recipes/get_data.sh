#!/usr/bin/env bash
# The clips that the manifests name, from where their makers publish them. get_data.py has the addresses.
exec python3 -B "$(dirname "${BASH_SOURCE[0]}")/get_data.py" "$@"
