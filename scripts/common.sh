# SPDX-License-Identifier: Apache-2.0
# Sourced by the scripts beside it: starts them in the repository's root and gives them what they share.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

cache=.cache # downloads and their logs; may be deleted at any time

# A CMake that scripts/setup fetched goes before a system's that is too old.
fetched_cmake=$cache/cmake/data/bin
if [[ -x $fetched_cmake/cmake ]]; then
  PATH=$PWD/$fetched_cmake:$PATH
fi

die() {
  echo "$(basename "$0"): $*" >&2
  exit 1
}

# One job a processor we may use, as taskset and containers restrict it.
jobs=$(nproc)
