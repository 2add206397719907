#!/usr/bin/env bash
# From a clone to a picture: installs and builds what is missing, starts a coordinator and two workers on this machine,
# renders scenes/cornell-box on them, and stops them again: a line a phase, with its time. Leaves cornell-box.exr and cornell-box.png
# in the current directory.
#
#   deploy/demo.sh [option of `tessera submit`]...      for example: deploy/demo.sh --spp 1024
. "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
esac

"$top/deploy/setup.sh"
build release programs
bin=$top/build/release/bin

state=$(mktemp -d)
pids=()
cleanup() {
  # Workers first: they give their leases back.
  stop_all "${pids[@]:1}"
  stop_all "${pids[@]:0:1}"
  rm -rf "$state"
}
trap cleanup EXIT
trap 'exit 130' INT TERM

show_logs() { tail -n 20 "$state"/*.log >&2; }

begin "starting a coordinator and two workers"
"$bin/tessera-server" --listen 127.0.0.1:0 --data "$state/server" >"$state/server.log" 2>&1 &
pids+=($!)
server=
for _ in $(seq 100); do
  server=$(sed -n 's/.*listening on \(127\.0\.0\.1:[0-9]*\).*/\1/p' "$state/server.log" | head -n 1)
  if [ -n "$server" ] || ! kill -0 "${pids[0]}" 2>/dev/null; then break; fi
  sleep 0.1
done
[ -n "$server" ] || {
  echo
  show_logs
  die "the coordinator did not start"
}
threads=$((($(nproc) + 1) / 2))
for worker in 1 2; do
  "$bin/tessera-worker" --server "$server" --threads "$threads" --cache "$state/cache$worker" \
    >"$state/worker$worker.log" 2>&1 &
  pids+=($!)
done

end

say "rendering scenes/cornell-box on $server"
"$bin/tessera" submit "$top/scenes/cornell-box/scene.pbrt" --server "$server" -o cornell-box.exr "$@" || {
  status=$?
  show_logs
  exit "$status"
}
"$bin/tessera" convert cornell-box.exr cornell-box.png
say "done in $(minutes $SECONDS): $PWD/cornell-box.exr and $PWD/cornell-box.png"
