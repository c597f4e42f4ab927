#!/usr/bin/env bash
# Install a build somewhere else, and build and run a program against that: by CMake and by
# pkg-config. Usage: test.sh BUILD_FOLDER
set -euo pipefail
build=$(realpath -- "$1")
here=$(realpath -- "$(dirname -- "$0")")
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT

cmake --install "$build" --prefix "$place/there" >"$place/install.txt"
cmake -S "$here" -B "$place/by-cmake" -DCMAKE_PREFIX_PATH="$place/there" >"$place/configure.txt"
cmake --build "$place/by-cmake" >"$place/build.txt"

libraries=$(dirname -- "$(find "$place/there" -name sunder.pc)")
export PKG_CONFIG_PATH=$libraries
# shellcheck disable=SC2046
cc "$here/cylinder.c" -o "$place/by-pkg-config" $(pkg-config --cflags --libs sunder)

cd "$place"
"$place/by-cmake/cylinder" | tee first.txt
LD_LIBRARY_PATH=$(dirname -- "$libraries") "$place/by-pkg-config" >second.txt
cmp first.txt second.txt
"$place/there/bin/sunder" --version
# It reads the problems that were installed with it, not those of the place where it was built.
sed -i 's/^title: .*/title: An installed cylinder/' "$place/there/share/sunder/problems/thick_cylinder/scene.yaml"
"$place/there/bin/sunder" problems | grep -q '^thick_cylinder  *An installed cylinder$'
# The program ran without any file, and its books close.
grep -Eq '^[1-9][0-9]* points: .*dissipated [1-9].*imbalance -?[0-9.]+e-0[3-9]$' first.txt
