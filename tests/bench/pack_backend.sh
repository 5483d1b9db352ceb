#!/usr/bin/env bash
# Packs build/bench/backend for a machine that has nothing of this project: pack_backend.sh [OUT=backend.tar.gz]
# [BUILD=build-pack]; there, unpacked: backend/backend [OPTIONS]. It is built anew, with OpenMP instead of oneTBB and with
# the compiler's libraries inside, so that it needs the C library (no older than here), EGL and libepoxy. EGL and the
# driver must be that machine's own; libepoxy lies beside it.
set -euo pipefail
source_dir=$(cd "$(dirname "$0")/../.." && pwd)
out=${1:-backend.tar.gz}
build=${2:-build-pack}
gomp=$("${CXX:-g++}" -print-file-name=libgomp.a)
cmake -S "$source_dir" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DANYRATE_OPENMP=ON \
    -DOpenMP_gomp_LIBRARY="$gomp" -DCMAKE_EXE_LINKER_FLAGS="-static-libstdc++ -static-libgcc -Wl,-rpath,'\$ORIGIN'"
cmake --build "$build" --target backend
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
mkdir "$folder/backend"
cp "$build/bench/backend" "$folder/backend/"
needed=$(objdump -p "$build/bench/backend" | awk '$1 == "NEEDED" { print $2 }')
while read -r library; do
    case $library in
        libc.so.6 | libm.so.6 | libdl.so.2 | libpthread.so.0 | ld-linux-*) ;;
        libepoxy.so.0) cp -L "$(ldd "$build/bench/backend" | awk '$1 == "libepoxy.so.0" { print $3 }')" "$folder/backend/" ;;
        *) echo "pack_backend.sh: the program needs $library, which a bare machine has not" >&2; exit 1 ;;
    esac
done <<<"$needed"
tar -C "$folder" -czf "$out" backend
