#!/bin/sh
# Installs everything elsewhere and uses it as a stranger would: the programs, the library by pkg-config, by find_package,
# from Python. Usage: prefix.sh BUILD_DIRECTORY SOURCE_DIRECTORY
set -eu
build=$1
source=$2
directory=$(mktemp -d)
trap 'rm -rf "$directory"' EXIT

# Staged, as a packager does: what leaves the prefix is found here and not on this machine, and nothing lies where it was told.
DESTDIR=$directory/stage cmake --install "$build" --prefix /any/where >/dev/null
prefix=$directory/stage/any/where
if strays=$(find "$directory/stage" ! -type d ! -path "$prefix/*" | grep .); then
  printf 'installed outside of the prefix:\n%s\n' "$strays" >&2
  exit 1
fi
library=$(dirname "$(find "$prefix" -name libhapticclient.so)")

echo "programs"
for program in sbin/hapticd bin/hapticctl bin/haptic-bench; do "$prefix/$program" --version; done
[ ! -x "$prefix/libexec/hapticd/hapticctl-cut" ] || "$prefix/bin/hapticctl" cut --help >/dev/null

echo "pkg-config"
export PKG_CONFIG_PATH="$library/pkgconfig"
flags=$(pkg-config --cflags --libs hapticclient)
# shellcheck disable=SC2086
cc -D_POSIX_C_SOURCE=200809L -std=c11 -Wall -Werror "$source/examples/01-state.c" $flags -o "$directory/c"
if LD_LIBRARY_PATH=$library HAPTICD_SOCKET=/nonexistent "$directory/c" 2>"$directory/said"; then
  echo "01-state found a daemon at /nonexistent" >&2
  exit 1
fi
grep -q "/nonexistent: no such socket" "$directory/said"

sed -n '/^```cpp/,/^```/p' "$source/README.md" | grep -v '^```' >"$directory/readme.cc"
# shellcheck disable=SC2086
c++ -std=c++20 -Wall -Werror "$directory/readme.cc" $flags -o "$directory/readme"

# shellcheck disable=SC2086
if c++ -std=c++17 -fsyntax-only "$directory/readme.cc" $flags 2>"$directory/said"; then
  echo "C++17 is taken"
  exit 1
fi
grep -q "error: .*needs C++20" "$directory/said"

echo "find_package"
mkdir "$directory/cmake"
cat >"$directory/cmake/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(stranger CXX)
find_package(hapticclient 0.1 REQUIRED)
add_executable(stranger stranger.cc)
target_link_libraries(stranger PRIVATE hapticclient::hapticclient)
target_compile_options(stranger PRIVATE -Wall -Wextra -pedantic -Werror)
END
cat >"$directory/cmake/stranger.cc" <<END
#include <hapticclient/hapticclient.hpp>
int main() { return haptic::Client::connect({.name = "stranger"}).code() == HAPTIC_DISCONNECTED ? 0 : 1; }
END
mkdir "$directory/cmake/c"
cat >"$directory/cmake/c/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(stranger C)
find_package(hapticclient 0.1 REQUIRED)
add_executable(stranger stranger.c)
target_link_libraries(stranger PRIVATE hapticclient::hapticclient)
END
cat >"$directory/cmake/c/stranger.c" <<END
#include <hapticclient/hapticclient.h>
int main(void) { return haptic_connect(NULL, NULL, NULL) == HAPTIC_INVALID_ARGUMENT ? 0 : 1; }
END
cmake -S "$directory/cmake/c" -B "$directory/cmake/c/build" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$directory/cmake/c/build" >/dev/null
"$directory/cmake/c/build/stranger"
cmake -S "$directory/cmake" -B "$directory/cmake/build" -DCMAKE_PREFIX_PATH="$prefix" >/dev/null
cmake --build "$directory/cmake/build" >/dev/null
HAPTICD_SOCKET=/nonexistent "$directory/cmake/build/stranger"

echo "python"
PYTHONDONTWRITEBYTECODE=1 PYTHONPATH="$prefix/lib/python3/dist-packages" /usr/bin/python3 -c 'import hapticclient; print(hapticclient.__version__)'
