#!/usr/bin/env bash
# Builds Claymeld into the environment that is active, or into the one of rattler-build. ODE 0.16.2, civetweb 1.15 and three.js 0.111 are
# not on conda-forge: their unpacked sources are expected in the folders that ODE_SOURCE, CIVETWEB_SOURCE and THREE_SOURCE name, or where
# recipe.yaml puts them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
prefix=${PREFIX:-${CONDA_PREFIX:?activate the environment first: conda activate claymeld}}
for library in ODE CIVETWEB THREE; do
    folder=${library}_SOURCE
    [ -n "${!folder:-}" ] || printf -v "$folder" %s "$PWD/third_party/${library,,}"
    [ -d "${!folder}" ] || { echo "packaging/conda/build.sh: say in $folder where the unpacked source of $library is" >&2; exit 2; }
done

build() {
    local source=$1
    shift
    local folder
    folder=$(mktemp -d)
    cmake -S "$source" -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_INSTALL_PREFIX="$prefix" \
        -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_INSTALL_LIBDIR=lib "$@"
    cmake --build "$folder" -j "${CPU_COUNT:-$(nproc)}"
    cmake --install "$folder"
    rm -rf "$folder"
}
build "$ODE_SOURCE" -DBUILD_SHARED_LIBS=ON -DODE_DOUBLE_PRECISION=ON -DODE_WITH_DEMOS=OFF -DODE_WITH_TESTS=OFF
build "$CIVETWEB_SOURCE" -DBUILD_SHARED_LIBS=ON -DCIVETWEB_BUILD_TESTING=OFF -DCIVETWEB_ENABLE_WEBSOCKETS=ON -DCIVETWEB_ENABLE_SSL=OFF \
    -DCIVETWEB_ENABLE_SERVER_EXECUTABLE=OFF
build . -DCLAYMELD_PROGRAMS_ONLY=ON -DCLAYMELD_UNITY=ON -DCLAYMELD_LLVM_ROOT="$prefix" -DTHREE_MODULE="$THREE_SOURCE/build/three.module.js"
