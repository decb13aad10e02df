#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# usage: scripts/check_heap_free.sh BUILD_DIR
# Fails when an archive of the control path refers to an allocator, a throw or a lock.
set -euo pipefail
build=$1

# With the way between two waypoints and the odometry, which are of the cycle. platform/linux makes the
# system calls; platform/toml, program_config and daemon read configurations before there is a cycle;
# robot_program takes the map's memory at start.
archives=$(find "$build/platform" "$build/ctrl" "$build/plan/motion/libplan_edge.a" \
  "$build/perception/localization" -name '*.a' ! -name 'libplatform_linux.a' ! -name 'libplatform_toml.a' \
  ! -name 'libctrl_robot_program.a' ! -name 'libctrl_program_config.a' ! -name 'libctrl_daemon.a' | sort)
[[ -n $archives ]] || { echo "check_heap_free: no archives under $build" >&2; exit 2; }

forbidden='(^|[^A-Za-z0-9_])(malloc|calloc|realloc|free|posix_memalign|aligned_alloc)$|operator (new|delete)|__cxa_(throw|allocate_exception)|pthread_mutex_lock|std::__throw'
failed=0
for archive in $archives; do
  hits=$(nm -uC "$archive" | sed 's/^ *U //' | grep -E "$forbidden" | grep -v '(unsigned long, void\*)$' | sort -u || true)
  if [[ -n $hits ]]; then
    echo "$archive refers to:" >&2
    sed 's/^/    /' <<<"$hits" >&2
    failed=1
  else
    echo "heap-free: ${archive##*/}"
  fi
done
exit $failed
