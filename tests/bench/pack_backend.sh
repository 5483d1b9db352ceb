#!/usr/bin/env bash
# Packs build/bench/backend with the libraries it needs but the C library and the driver, for a machine that has nothing
# of this project: pack_backend.sh [BUILD=build] [OUT=backend.tar.gz]; there, unpacked: backend/run [OPTIONS].
# EGL and the driver must be that machine's own.
set -euo pipefail
build=${1:-build}
out=${2:-backend.tar.gz}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder/backend/lib"
cp "$build/bench/backend" "$folder/backend/backend"
ldd "$build/bench/backend" | awk '$2 == "=>" { print $3 }' | grep -Ev '/(libc|libm|libdl|libpthread|librt)\.so|/libEGL|/libGL' |
    xargs -r cp -L -t "$folder/backend/lib"
cat >"$folder/backend/run" <<'RUN'
#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
LD_LIBRARY_PATH="$here/lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" exec "$here/backend" "$@"
RUN
chmod +x "$folder/backend/run"
tar -C "$folder" -czf "$out" backend
