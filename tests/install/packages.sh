#!/bin/sh
# Checks the Debian packages of a folder: packages.sh DIRECTORY SOURCE
# Names, files in Debian's places, scripts, dependencies; then extracts all of them into a scratch root, runs the daemon there and
# compiles an example against what was extracted, by pkg-config and by CMake.
set -eu
packages=$(cd "$1" && pwd)
source=$(cd "$2" && pwd)
scratch=$(mktemp -d)
daemon=
trap '[ -z "$daemon" ] || kill "$daemon" 2>/dev/null || true; rm -rf "$scratch"' EXIT
fail() { echo "packages: $*" >&2; exit 1; }

deb() { # the file of a package
  set -- "$packages/$1"_*.deb
  [ $# = 1 ] && [ -f "$1" ] || fail "$1 is not there, or more than once"
  echo "$1"
}
has() { # PACKAGE PATH...: files by shell pattern
  package=$1; shift
  dpkg-deb -c "$(deb "$package")" | awk '{ sub(/^\./, "", $6); print $6 }' > "$scratch/list"
  for path in "$@"; do
    while read -r file; do
      # shellcheck disable=SC2254
      case $file in $path) continue 2 ;; esac
    done < "$scratch/list"
    fail "$package lacks $path"
  done
}
depends() { # PACKAGE WORD...
  package=$1; shift
  for word in "$@"; do
    dpkg-deb -f "$(deb "$package")" Depends | grep -q "$word" || fail "$package does not depend on $word"
  done
}

has hapticd /usr/sbin/hapticd /usr/libexec/hapticd/hapticd-builder /usr/libexec/hapticd/hapticd-safe /usr/libexec/hapticd/hapticd-vendor /usr/share/hapticd/gpio/hapticd-gpio.conf /etc/hapticd/hapticd.toml \
  /usr/lib/systemd/system/hapticd.service /usr/lib/systemd/system/hapticd.socket \
  /usr/lib/systemd/system/hapticd-admin.socket /usr/lib/systemd/user/hapticd.service \
  /usr/lib/systemd/system/hapticd-vendor.socket /usr/lib/systemd/system/hapticd-vendor@.service \
  /usr/lib/systemd/system/hapticd.service.d/falcon.conf /usr/lib/systemd/system/hapticd.service.d/hid.conf \
  /usr/lib/udev/rules.d/60-hapticd.rules /usr/lib/sysusers.d/hapticd.conf /usr/lib/tmpfiles.d/hapticd.conf \
  /usr/share/doc/hapticd/copyright /usr/share/doc/hapticd/devices.md
depends hapticd libc6 libspdlog systemd
has hapticd-vdb /usr/libexec/hapticd/hapticd-builder-vdb
depends hapticd-vdb hapticd libopenvdb10.0
! dpkg-deb -f "$(deb hapticd)" Depends | grep -q openvdb || fail "hapticd itself needs OpenVDB"
has libhapticclient1 '/usr/lib/*/libhapticclient.so.1'
has libhapticclient-dev '/usr/lib/*/libhapticclient.so' '/usr/include/hapticclient/*.h' \
  /usr/share/doc/libhapticclient-dev/examples/01-state.c '/usr/lib/*/pkgconfig/hapticclient.pc' '/usr/lib/*/cmake/hapticclient/*onfig.cmake'
depends libhapticclient-dev 'libhapticclient1 (='
has python3-hapticclient '/usr/lib/python3/dist-packages/hapticclient/__init__.py'
depends python3-hapticclient python3-numpy
has hapticctl /usr/bin/hapticctl
depends hapticctl libhapticclient1
has hapticctl-import /usr/libexec/hapticd/hapticctl-import /usr/libexec/hapticd/hapticctl-cut
depends hapticctl-import 'hapticctl (>=' libopenvdb10.0
[ "$(dpkg --print-architecture)" != amd64 ] || depends hapticctl-import libinsighttoolkit5.2
has haptic-bench /usr/bin/haptic-bench /usr/include/haptic_algorithm.h /usr/share/haptic-bench/report/report.py \
  /usr/share/man/man1/haptic-bench.1.gz /usr/share/doc/haptic-bench/examples/example.c
depends haptic-bench libhapticclient1 libassimp5 python3

mkdir "$scratch/bin" # all that such a chroot offers
ln -s /bin/true "$scratch/bin/ldconfig"
ln -s /bin/true "$scratch/bin/rm" # postrm means this machine's folders
printf '#!/bin/sh\n/bin/echo "$*" >> "%s/systemctl"\n' "$scratch" > "$scratch/bin/systemctl"
chmod +x "$scratch/bin/systemctl"
for package in hapticd hapticd-vdb libhapticclient1 libhapticclient-dev python3-hapticclient hapticctl hapticctl-import haptic-bench; do
  file=$(deb "$package")
  dpkg-deb -e "$file" "$scratch/control-$package"
  dpkg-deb -x "$file" "$scratch/root"
  for script in "$scratch/control-$package"/p*; do
    [ -f "$script" ] || continue
    sh -n "$script" || fail "$script does not parse"
    # In a chroot without systemd, udev or anything else it must end well and do nothing.
    PATH=$scratch/bin /bin/sh "$script" "$(case $script in *postinst) echo configure ;; *) echo remove ;; esac)" ||
      fail "$script fails without systemd"
  done
done
for page in "$scratch/root/usr/share/doc/hapticd"/*.md; do # What a page refers to is there, but for the source.
  for link in $(grep -o '](\([a-z][a-z/-]*\.[a-z]*\)' "$page" | cut -c3-); do
    [ -f "$(dirname "$page")/$link" ] || fail "$page refers to $link, which no package has"
  done
done
# CPack calls ldconfig beside the trigger; and only systemctl disables what an administrator has enabled.
lintian --fail-on error,warning --allow-root --suppress-tags maintscript-calls-ldconfig,maintainer-script-calls-systemctl "$packages"/*.deb ||
  fail "lintian"
# Where an image is made units can be enabled; removal takes the links away there, too, and asks nothing of a systemd that does not run.
[ -d /run/systemd/system ] || grep -q 'disable.* hapticd.socket' "$scratch/systemctl" || fail "prerm leaves enabled units behind"
[ -d /run/systemd/system ] || ! grep -qv 'disable' "$scratch/systemctl" || fail "scripts ask a systemd that does not run"
grep -q py3clean "$scratch/control-python3-hapticclient/prerm" || fail "python3-hapticclient leaves byte code behind, which can be imported"
while read -r conffile; do
  [ -f "$scratch/root$conffile" ] || fail "conffile $conffile is not packaged"
done < "$scratch/control-hapticd/conffiles"
# The pages name files as they are installed.
for page in "$scratch"/root/usr/share/man/man?/*.gz; do
  zcat "$page" | grep -o '^\.\(It \)\?Pa [a-z/][^ ]*/[^ ]*\|/usr/share/hapticd/[^ ]*' | sed 's/.*Pa //' > "$scratch/named"
  while read -r named; do
    case $named in /usr/*) [ -e "$scratch/root$named" ] || fail "${page##*/} names $named, which is not packaged" ;;
      /*) ;;
      *) fail "${page##*/} names $named, which is a path of the source" ;;
    esac
  done < "$scratch/named"
done
[ -z "$(find "$scratch/root/usr" "$scratch/root/etc" -perm /022 ! -type l)" ] || fail "files that others may write"

# The daemon runs from where it lies, and finds its builder.
"$scratch/root/usr/sbin/hapticd" --config "$scratch/root/etc/hapticd/hapticd.toml" --allow-no-rt --device sim://default \
  --socket "$scratch/run/c.sock" > "$scratch/log" 2>&1 &
daemon=$!
i=0
until grep -qs ready "$scratch/log"; do
  i=$((i + 1))
  [ $i -lt 200 ] && kill -0 $daemon 2>/dev/null || { cat "$scratch/log" >&2; fail "hapticd does not start"; }
  sleep 0.05
done
! grep -q 'cannot be loaded' "$scratch/log" || fail "hapticd does not find its builder"
library=$(dirname "$(find "$scratch/root/usr/lib" -name libhapticclient.so.1)")
export LD_LIBRARY_PATH="$library"
# Who finds no daemon is told how to start one: users have no /usr/sbin in their PATH.
named=$(HAPTICD_SOCKET="$scratch/none" "$scratch/root/usr/bin/hapticctl" list 2>&1 | grep -o '[^ ]* --allow-no-rt')
[ -x "$scratch/root${named% *}" ] || fail "hapticctl names a program that nobody finds: $named"
HAPTICD_SOCKET="$scratch/run/c.sock" "$scratch/root/usr/bin/hapticctl" list || fail "hapticctl list"
HAPTICD_SOCKET="$scratch/run/c.sock" "$scratch/root/usr/bin/hapticctl" record "$scratch/session.hrec" --for 0.5 || fail "hapticctl record"
kill $daemon
wait $daemon || fail "hapticd does not end well"
daemon=

# The benchmark finds what it draws with, and judges an algorithm made with its header.
bench=$scratch/root/usr/bin/haptic-bench
cc -shared -fPIC -I "$scratch/root/usr/include" -o "$scratch/facet.so" "$scratch/root/usr/share/doc/haptic-bench/examples/example.c" -lm
"$bench" run -a ours "$scratch/facet.so" -m plane -t lissajous:seconds=0.1 --rounds 1 > "$scratch/log" ||
  fail "haptic-bench judges no plug-in"
printf 'a,b\n1\n' > "$scratch/nonsense.csv" # refused by the script, before anything is measured
"$bench" replay --verify "$scratch/session.hrec" || fail "haptic-bench replays what the daemon recorded otherwise"
env -u PYTHONDONTWRITEBYTECODE "$bench" report "$scratch/page.html" --with "$scratch/nonsense.csv" 2> "$scratch/said" && fail "haptic-bench report takes nonsense"
grep -q "nonsense.csv: holds no table" "$scratch/said" || { cat "$scratch/said" >&2; fail "haptic-bench does not find its report"; }
[ -z "$(find "$scratch/root/usr/share" -name __pycache__)" ] || fail "haptic-bench report leaves byte code that no package removes"
! grep -qs "$source/" "$bench" || fail "haptic-bench names the folder in which it was built"

# A program against the packages alone.
cat > "$scratch/program.c" <<'C'
#include <hapticclient/hapticclient.h>
#include <stdio.h>
int main(void) { return printf("%s\n", haptic_error_name(HAPTIC_OK)) > 0 ? 0 : 1; }
C
# shellcheck disable=SC2046
cc -o "$scratch/program" "$scratch/program.c" $(PKG_CONFIG_SYSROOT_DIR="$scratch/root" PKG_CONFIG_LIBDIR="$library/pkgconfig" \
  pkg-config --cflags --libs hapticclient) || fail "pkg-config"
"$scratch/program"
mkdir "$scratch/project"
cat > "$scratch/project/CMakeLists.txt" <<'C'
cmake_minimum_required(VERSION 3.16)
project(program C)
find_package(hapticclient REQUIRED)
add_executable(program ../program.c)
target_link_libraries(program hapticclient::hapticclient)
C
cmake -S "$scratch/project" -B "$scratch/project/build" -DCMAKE_PREFIX_PATH="$scratch/root/usr" > "$scratch/log" &&
  cmake --build "$scratch/project/build" >> "$scratch/log" || { cat "$scratch/log" >&2; fail "find_package"; }
"$scratch/project/build/program"
echo "packages: all good"
