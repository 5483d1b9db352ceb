#!/usr/bin/env bash
# Installs every Debian 12 package that building, testing and running Anyrate needs; as root, or through sudo.
# Asks the network only if something is missing, so it costs nothing to run again.
#   install.sh        everything
#   install.sh run    what a finished build/anyrate needs to run, and curl to ask whether it is well
set -euo pipefail

packages=(
    # building
    build-essential cmake ninja-build ccache git ca-certificates pkg-config
    # core: geometry and images
    libeigen3-dev libtbb-dev libopenmesh-dev libpng-dev libturbojpeg0-dev libarchive-dev
    # proto
    libdraco-dev nlohmann-json3-dev
    # gpu: EGL and OpenGL, and Mesa's llvmpipe, which stands in for a GPU in tests
    libepoxy-dev libegl-dev libegl1 libegl-mesa0 libgl1-mesa-dri
    # server
    libcli11-dev libspdlog-dev libsqlite3-dev libseccomp-dev libssl-dev
    # tests and scripts; OpenCV as another reader of images; Clang for libFuzzer, with its runtime and names in its reports
    doctest-dev libopencv-core-dev libopencv-imgcodecs-dev curl python3 python3-yaml openssl clang libclang-rt-14-dev llvm zzuf
)

# The libraries of the binary itself (tests/docker_test.py compares); theirs follow.
run_packages=(
    libarchive13 libpng16-16 libturbojpeg0 libopenmesh1 libdraco7 libtbb12
    libsqlite3-0 libseccomp2 libssl3 libspdlog1.10 libfmt9 libstdc++6 libepoxy0 libegl1 curl ca-certificates
)

is_installed() {
    [ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]
}

case "${1:-}" in
run)
    packages=("${run_packages[@]}")
    ;;
"")
    # Boost 1.81 (Beast, Asio, URL) cannot stand beside the headers of Debian's default 1.74, which also serve.
    if ! is_installed libboost1.74-dev; then
        packages+=(libboost1.81-dev libboost-url1.81-dev)
    fi

    # The viewer's tests run in a browser.
    packages+=(chromium)

    # The web client and viewer. A nodejs from elsewhere brings its own npm, which stands in the way of Debian's.
    if ! { command -v node && command -v npm; } >/dev/null; then
        packages+=(nodejs npm)
    fi
    ;;
*)
    echo "install.sh: expected nothing or \"run\", got \"$1\"" >&2
    exit 2
    ;;
esac

missing=()
for package in "${packages[@]}"; do
    is_installed "$package" || missing+=("$package")
done
if [ ${#missing[@]} -eq 0 ]; then
    exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "install.sh: not root and no sudo; missing: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
fi
echo "install.sh: installing ${missing[*]}"
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
