#!/usr/bin/env bash
# The demo, on a fresh Debian 12 machine: installs, builds, photographs the vessel scene, reconstructs it through a server
# and prints the viewer's address. What is there already is not made again.
#
# usage: server/run.sh [--once]      --once checks that the server answers and ends; otherwise Ctrl-C ends it
# environment: ANYRATE_LISTEN, where to listen (default 127.0.0.1:8080; with --once any free port)
set -euo pipefail
cd "$(dirname "$0")/.."
once=false
case "${1:-}" in
    "") ;;
    --once) once=true ;;
    *) echo "usage: server/run.sh [--once]" >&2; exit 2 ;;
esac

listen=${ANYRATE_LISTEN:-127.0.0.1:$($once && echo 0 || echo 8080)}
demo=build/demo
anyrate=build/anyrate
n_vertices=10000

bash docker/install.sh
mkdir -p "$demo"
echo "== build"
# npm ci deletes and fetches everything, so it runs only when the lock file is newer than what it left.
if ! [ web/node_modules/.package-lock.json -nt web/package-lock.json ]; then
    npm ci --prefix web --no-audit --no-fund >"$demo/npm.log" 2>&1 || { tail -n 40 "$demo/npm.log" >&2; exit 1; }
fi
npm run --prefix web viewer >"$demo/viewer.log" 2>&1 || { tail -n 40 "$demo/viewer.log" >&2; exit 1; }
if ! { cmake -S . -B build -G Ninja && cmake --build build --target anyrate; } >"$demo/build.log" 2>&1; then
    tail -n 40 "$demo/build.log" >&2
    exit 1
fi

if [ ! -d "$demo/capture" ]; then
    echo "== simulate a capture"
    rm -rf "$demo/capture.part"
    "$anyrate" simulate --scene vessel -o "$demo/capture.part"
    mv "$demo/capture.part" "$demo/capture"
fi

echo "== serve"
: >"$demo/serve.log"  # there before it is read: the server's own start may come later
"$anyrate" serve --listen "$listen" --data "$demo/data" >"$demo/serve.log" 2>&1 &
server=$!
trap 'kill "$server" 2>/dev/null && wait "$server" || true' EXIT
url=
for _ in $(seq 100); do
    if ! kill -0 "$server" 2>/dev/null; then
        tail -n 5 "$demo/serve.log" >&2
        exit 1
    fi
    url=$(sed -n 's/^listening on //p' "$demo/serve.log")
    [ -n "$url" ] && break
    sleep 0.1
done
curl -fsS "$url/healthz" >/dev/null

# The model of the last run, if the server still has it.
id=$(cat "$demo/model-id" 2>/dev/null || true)
if [ -z "$id" ] || ! curl -fsS "$url/v1/models/$id" 2>/dev/null | grep -q '"done"'; then
    echo "== reconstruct"
    id=$("$anyrate" push "$demo/capture" --server "$url" --wait --vertices "$n_vertices")
    echo "$id" >"$demo/model-id"
fi

if $once; then
    echo "== check"
    "$anyrate" fetch "$url/v1/models/$id" -o "$demo/fetched.ply" --vertices 5000
    curl -fsS "$url/v1/models/$id/log?vertices=5000" -o "$demo/prefix.arl"
    "$anyrate" decode "$demo/prefix.arl" -o "$demo/decoded.ply" --vertices 5000
    cmp "$demo/fetched.ply" "$demo/decoded.ply"
    n=$(grep -am1 '^element vertex' "$demo/decoded.ply" | cut -d' ' -f3)
    [ "$n" -ge 4998 ] && [ "$n" -le 5000 ] || { echo "asked for 5000 vertices, got $n" >&2; exit 1; }
    curl -fsS "$url/models/$id" | grep -q '<div id="app">' || { echo "the viewer's page is not there" >&2; exit 1; }
    echo "$url answers; the prefix for 5000 vertices decodes to $n"
else
    echo "The viewer: $url/models/$id, all models: $url/ (Ctrl-C ends the server)"
    wait "$server"
fi
