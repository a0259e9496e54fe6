#!/bin/sh
# What others get: the tarball and what it builds, the installed tree with its
# manual, completion and examples, Debian's packages.  Runs `make distcheck`
# without the tests, which would be these once more.
. "$srcdir/test/support/tap.sh"

if test -n "$HBIL_PACKAGING"; then
  skip "tarball, installed tree, packages" "this is such a build"
  echo "1..$count"
  exit 0
fi
HBIL_PACKAGING=1
export HBIL_PACKAGING
# of the make that runs this test
unset MAKEFLAGS MFLAGS MAKELEVEL MAKEOVERRIDES TESTS DESTDIR

version=$("$HBIL" --version | sed 's/hbil //')
tree=hbil-$version
# for builds that nothing repeats; of the library, only the shared one
once='--disable-static --disable-dependency-tracking CFLAGS=-O0 CXXFLAGS=-O0'
here=$PWD

# have NAME COMMAND...: whether they are all there; otherwise NAME is skipped.
have() {
  name=$1
  shift
  for command; do
    if ! command -v "$command" >/dev/null; then
      skip "$name" "no $command"
      return 1
    fi
  done
}

# files FOLDER: what lies in it, sorted.
files() {
  (cd "$1" && find . ! -type d | sed 's|^\./||' | sort)
}

# kernels FOLDER: where they are installed.
kernels() {
  (cd "$srcdir" && find kernels -name '*.cl' -o -name '*.clh' -o -name '*.h') |
    sed "s|^|$1/|"
}

# documents FOLDER: what is there to read, and the examples, where they are installed.
documents() {
  (cd "$srcdir" && find README.md COPYING NEWS doc/*.md doc/*.png doc/*.svg examples \
    -type f) | sed "s|^|$1/|"
}

# headers FOLDER: the public headers, in it.
headers() {
  (cd "$srcdir/include/hbil" && ls) | sed "s|^|$1/|"
}

# --- versions ---

numbers=$(sed -n 's/^#define HBIL_VERSION_M[AI][JN]OR \|^#define HBIL_VERSION_PATCH //p' \
  "$srcdir/include/hbil/hbil_base.h" | paste -sd. -)
{
  echo "hbil_base.h $numbers"
  echo "hbil.pc $(sed -n 's/^Version: //p' src/hbil/hbil.pc)"
  echo "NEWS $(sed -n '1s/^hbil \([0-9.]*\).*/\1/p' "$srcdir/NEWS")"
  echo "changelog $(sed -n '1s/^hbil (\([0-9.]*\)).*/\1/p' "$srcdir/debian/changelog")"
} >"$work/out"
! grep -v " $version\$" "$work/out" >"$work/err"
ok $? "header, package, NEWS and Debian's changelog have one version"

# --- the tarball ---

# The tests' programs are not compiled once more: the comparison below shows that
# the tarball has them.  Nor is the library for a static one, which the installed
# tree and the packages have.
works "make distcheck" make distcheck TESTS= check_PROGRAMS= \
  check_LTLIBRARIES= "DISTCHECK_CONFIGURE_FLAGS=$once"
mv "$tree.tar.gz" "$work" && (cd "$work" && tar xzf "$tree.tar.gz")

name="the tarball has the files of the repository, and what autotools make of them"
if git -C "$srcdir" rev-parse --show-toplevel >"$work/top" 2>/dev/null &&
  test "$(cat "$work/top")" -ef "$srcdir"; then
  git -C "$srcdir" ls-files | grep -v '^\.ci/\|^\.gitignore$\|^m4/\.gitkeep$' |
    sort >"$work/tracked"
  files "$work/$tree" | grep -v -x -e 'build-aux/.*' -e 'm4/.*' -e 'man/.*' \
    -e 'completion/.*' -e 'Makefile\.in' -e 'aclocal\.m4' -e 'config\.h\.in' \
    -e configure >"$work/packed"
  same_lists "$name" "$work/tracked" "$work/packed"
else
  skip "$name" "no repository"
fi

# --- the way that README.md calls classic, without the tool ---

classic=$(sed -n 's/^ *\(autoreconf -fi && .*make install\)$/\1/p' \
  "$srcdir/README.md" |
  sed "s|\./configure|./configure -q --disable-tool --prefix=$work/plain $once|")
classic() {
  cp -pR "$work/$tree" "$work/classic" && cd "$work/classic" && eval "$classic"
}
name="README.md's classic commands, for the library alone"
have "$name" autoreconf && {
  run classic
  test $status -eq 0 && test -n "$classic"
  ok $? "$name"
  has "the library alone: header, pkg-config file, manual" \
    "$work/plain/include/hbil/hbil.h" "$work/plain/lib/pkgconfig/hbil.pc" \
    "$work/plain/lib/libhbil.so.1" "$work/plain/share/man/man3/hbil.3"
  absent "but no tool" "$work/plain/bin/hbil"
  works "make installcheck without the tool" make -C "$work/classic" installcheck
}
cd "$here" || exit 99

# --- what is installed ---

root=$work/root
works "make install" make -s install "DESTDIR=$root"
lib=$(find "$root" -name libhbil.so.1 -exec dirname {} \;)
share=$(find "$root" -name kernels -exec dirname {} \; | sed 's|/hbil$||')
prefix=${share%/share}
find "$share/man" -type f -size 0 >"$work/empty"
ok $(($(wc -l <"$work/empty") > 0)) "no manual page is empty"
files "$prefix" | grep -v '^share/man/man3/' >"$work/installed"
sort >"$work/expected" <<END
bin/hbil
$(headers include/hbil)
lib/cmake/hbil/hbilConfig.cmake
lib/cmake/hbil/hbilConfigVersion.cmake
lib/hbil/hbil-formats.so
lib/libhbil.a
lib/libhbil.la
lib/libhbil.so
lib/libhbil.so.1
lib/libhbil.so.1.0.0
lib/pkgconfig/hbil.pc
share/bash-completion/completions/hbil
$(documents share/doc/hbil)
$(kernels share/hbil)
share/man/man1/hbil.1
share/zsh/site-functions/_hbil
END
same_lists "make install installs what it should" "$work/expected" "$work/installed"
objdump -p "$lib/libhbil.so" | grep SONAME >"$work/out"
grep -q ' libhbil\.so\.1$' "$work/out"
ok $? "the soname is libhbil.so.1"
works "make installcheck: an example by pkg-config alone" \
  make -s installcheck "DESTDIR=$root"

# --- the manual ---

functions=$(awk '/^HBIL_API/ { api = 1 }
  api && match($0, /hbil_[a-z0-9_]+\(/) {
    print substr($0, RSTART, RLENGTH - 1); api = 0 }' \
  "$srcdir"/include/hbil/*.h)
man=$share/man
missing=0
: >"$work/out"
for function in $functions; do
  page=$man/man3/$function.3
  target=$(sed -n 's/^\.so //p' "$page")
  grep -q "$function(" "$man/${target:-man3/$function.3}" ||
    { echo "$function"; missing=1; } >>"$work/out"
done
ok $missing "every function has a page that declares it"
options() { # COMMAND
  "$HBIL" "$1" --help | grep '^  ' |
    grep -o -e '^ *-.*' | grep -o -e '^ *-[a-z], --[a-z-]*' -e '^ *--[a-z-]*' |
    sed 's/.*--/--/' | sort -u
}
missing=0
: >"$work/out"
sed 's/\\-/-/g' "$man/man1/hbil.1" >"$work/hbil.1"
commands=$("$HBIL" --help | sed -n 's/^  \([a-z][a-z]*\) .*/\1/p')
for command in $commands; do
  for option in $(options "$command"); do
    sed -n "/^\.SH HBIL $(echo "$command" | tr a-z A-Z)\$/,/^\.SH/p" "$work/hbil.1" |
      grep -q -e "^\\\\fB.*$option\\\\fR" ||
      { echo "$command $option"; missing=1; } >>"$work/out"
  done
done
ok $missing "hbil(1) has every option of every command"
name="the pages are sound to groff"
have "$name" groff && {
  groff -man -Tutf8 -ww -z "$man"/man1/*.1 >"$work/out" 2>"$work/err"
  for page in "$man"/man3/*.3; do
    grep -q '^\.so' "$page" || groff -man -Tutf8 -ww -z "$page"
  done >>"$work/out" 2>>"$work/err"
  test ! -s "$work/err"
  ok $? "$name"
}

# --- completion ---

# complete WORD...: what is offered for the last one, one a line
complete() {
  program=$HBIL bash -c 'compopt() { :; }
    source "$0"
    COMP_WORDS=(hbil "$@") COMP_CWORD=$#
    _hbil "$program" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
    printf "%s\n" "${COMPREPLY[@]}"' \
    "$share/bash-completion/completions/hbil" "$@" | sort -u
}
have "completion for bash" bash && {
  printf '%s\n' $commands --help --version | sort >"$work/expected"
  complete '' >"$work/offered"
  same_lists "bash is offered the commands" "$work/expected" "$work/offered"
  : >"$work/expected"
  : >"$work/offered"
  for command in $commands; do
    options "$command" >>"$work/expected"
    complete "$command" -- | grep . >>"$work/offered"
  done
  same_lists "bash is offered every option of every command" "$work/expected" "$work/offered"
  printf '%s\n' balanced fast high reference >"$work/expected"
  complete process --quality '' >"$work/offered"
  same_lists "bash is offered the words of an option" "$work/expected" "$work/offered"
  printf '%s\n' ao,beauty ao,bent_normal | sort -u >"$work/expected"
  complete process --layers ao,be >"$work/offered"
  same_lists "and those of a list behind a comma" "$work/expected" "$work/offered"
  "$HBIL" devices | awk '{ print $1 }' | sort -u >"$work/expected"
  complete process --device '' >"$work/offered"
  same_lists "and the devices of this machine" "$work/expected" "$work/offered"
}
name="completion for zsh is sound"
have "$name" zsh && works "$name" zsh -n "$share/zsh/site-functions/_hbil"

# --- examples, with what is installed and nothing else ---

PATH=$prefix/bin:$PATH
LD_LIBRARY_PATH=$lib${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}
PKG_CONFIG_PATH=$lib/pkgconfig${PKG_CONFIG_PATH:+:$PKG_CONFIG_PATH}
PKG_CONFIG_SYSROOT_DIR=$root
export PATH LD_LIBRARY_PATH PKG_CONFIG_PATH PKG_CONFIG_SYSROOT_DIR
unset HBIL
compile=$(sed -n 's/.*`\(cc [^`]*\)`.*/\1/p' "$srcdir/README.md")
for example in "$share"/doc/hbil/examples/*.c; do
  cp "$example" "$work/program.c"
  run eval "cd $work && $compile -lpthread -o program"
  test $status -eq 0 && test -n "$compile"
  ok $? "README.md's compiler command builds $(basename "$example")"
done
name="examples/README.md's command builds 08_cpp.cpp"
compile=$(sed -n 's/^    \(c++ .*08_cpp.*\)$/\1/p' "$share/doc/hbil/examples/README.md")
if test -x "$here/examples/08_cpp"; then
  cp "$share/doc/hbil/examples/08_cpp.cpp" "$work"
  run eval "cd $work && $compile -o program"
  test $status -eq 0 && test -n "$compile"
  ok $? "$name"
else
  skip "$name" "no CL/opencl.hpp (opencl-clhpp-headers)"
fi
cd "$here" || exit 99

# with_cmake VERSION [LIBRARIES]: an example built by find_package(hbil VERSION), and run
with_cmake() {
  rm -rf "$work/cmake"
  cmake -S "$srcdir/test/system/cmake" -B "$work/cmake" "-DWANTED=$1" \
    "-DPROGRAM=$share/doc/hbil/examples/01_minimal.c" "-Dhbil_DIR=${2:-$lib}/cmake/hbil" &&
    cmake --build "$work/cmake" && "$work/cmake/program"
}
have "CMake: find_package(hbil)" cmake && {
  works "CMake: find_package(hbil) builds an example, which runs" with_cmake "$version"
  works "CMake: any version of the series is served" with_cmake "${version%.*}"
  for other in "${version%.*}.99" 99.0 0.0; do
    run with_cmake "$other"
    test $status -ne 0 && grep -q "requested version \"$other\"" "$work/err"
    ok $? "CMake: but no version $other"
  done
  cp -R "$prefix" "$work/moved"
  rm -f "$work"/moved/lib/libhbil.so*
  works "CMake: in a tree that was moved, with the static library alone" \
    with_cmake "$version" "$work/moved/lib"
  grep -q 'moved/lib/libhbil\.a' "$work/cmake/CMakeFiles/program.dir/link.txt"
  ok $? "CMake: which is what was linked"
}

name="example 06: a sequence as a contact sheet"
{
  run hbil demo --frames 2 --size 64x48 -o "$work/demo"
  works "$name" "$srcdir/examples/06_contact_sheet.sh" "$work/sheet.png" \
    "$work"/demo/gbuffer/frame_*.exr
  has "there is a sheet" "$work/sheet.png"
  run "$srcdir/examples/06_contact_sheet.sh" "$work/none.png" "$work/none.exr"
  test $status -ne 0 && test ! -e "$work/none.png"
  ok $? "a frame that is not there gives no sheet"
  if test -e "$HBIL_DATA/cornell/frame_0001.exr"; then
    works "the same of frames that Blender has written" \
      "$srcdir/examples/06_contact_sheet.sh" "$work/cornell.png" \
      "$HBIL_DATA/cornell/frame_0001.exr"
  else
    skip "the same of frames that Blender has written" \
      "no dumps in $HBIL_DATA/cornell"
  fi
}

unset PKG_CONFIG_PATH PKG_CONFIG_SYSROOT_DIR
works "make uninstall" make -s uninstall "DESTDIR=$root"
{
  files "$root"
  find "$root" -name '*hbil*'
} >"$work/out"
test ! -s "$work/out"
ok $? "make uninstall leaves nothing"

# --- Debian's packages ---

name="dpkg-buildpackage"
# package NAME: the files in it, with the system's triplet left out
package() {
  dpkg-deb -c "$work/$1"_*.deb | awk '!/\/$/ { sub(/^\./, "", $6); print $6 }' |
    sed "s|/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH)/|/lib/|
      s|\.gz\$||" | grep -v '^/usr/share/doc/' | sort
}
if have "$name" dpkg-buildpackage dpkg-checkbuilddeps dh; then
  if DEB_BUILD_PROFILES=nocheck dpkg-checkbuilddeps "$srcdir/debian/control" \
    >"$work/out" 2>&1; then
    run eval "cd $work/$tree && env DEB_BUILD_PROFILES=nocheck \
      DPKG_DEB_COMPRESSOR_LEVEL=0 \
      DEB_BUILD_OPTIONS='nocheck noopt noautodbgsym' dpkg-buildpackage -us -uc"
    cd "$here" || exit 99
    ok $status "$name"
    printf '%s\n' /usr/lib/libhbil.so.1 /usr/lib/libhbil.so.1.0.0 >"$work/expected"
    package libhbil1 >"$work/offered"
    same_lists "libhbil1 has the library" "$work/expected" "$work/offered"
    {
      headers /usr/include/hbil
      printf '/usr/%s\n' lib/libhbil.a lib/libhbil.so lib/pkgconfig/hbil.pc \
      lib/cmake/hbil/hbilConfig.cmake lib/cmake/hbil/hbilConfigVersion.cmake
      kernels /usr/share/hbil
      printf '/usr/share/man/man3/%s.3\n' $functions
    } | sort >"$work/expected"
    # pages of parts and of types come on top
    package libhbil-dev >"$work/all"
    grep -v -x -F -f "$work/expected" "$work/all" | grep -v /man/man3/ >"$work/more"
    { grep -x -F -f "$work/expected" "$work/all"; cat "$work/more"; } | sort >"$work/offered"
    same_lists "libhbil-dev has header, static library, kernels and manual" \
      "$work/expected" "$work/offered"
    printf '%s\n' /usr/bin/hbil /usr/lib/hbil/hbil-formats.so \
      /usr/share/bash-completion/completions/hbil /usr/share/man/man1/hbil.1 \
      /usr/share/zsh/vendor-completions/_hbil >"$work/expected"
    package hbil-tools >"$work/offered"
    same_lists "hbil-tools has program, manual and completion" \
      "$work/expected" "$work/offered"
    {
      printf '/usr/lib/python3/dist-packages/hbil/%s\n' _declarations.py
      (cd "$srcdir/python" && ls hbil/*.py hbil/py.typed) |
        sed 's|^|/usr/lib/python3/dist-packages/|'
    } | sort >"$work/expected"
    package python3-hbil >"$work/offered"
    same_lists "python3-hbil has the package, and what the headers declare" \
      "$work/expected" "$work/offered"
    dpkg-deb -c "$work"/libhbil-dev_*.deb >"$work/out"
    awk '!/\/$/ { sub(/^\./, "", $6); print $6 }' "$work/out" | grep '/doc/.*/' |
      grep -v -e changelog -e copyright | sed "s/NEWS\.gz/NEWS/" | sort >"$work/offered"
    documents /usr/share/doc/libhbil-dev | grep -v COPYING | sort >"$work/expected"
    same_lists "libhbil-dev has the documents and the examples, as they are" \
      "$work/expected" "$work/offered"
    dpkg-deb -c "$work"/hbil-tools_*.deb >"$work/out"
    grep -q 'doc/hbil-tools/doc/guide\.md$' "$work/out"
    ok $? "hbil-tools has the guide"
    dpkg-deb -f "$work"/hbil-tools_*.deb Depends >"$work/out"
    grep -q 'libhbil1 (>= ' "$work/out"
    ok $? "hbil-tools needs libhbil1, of its version at least"
    for deb in "$work"/*.deb; do dpkg-deb -x "$deb" "$work/system"; done
    ! objdump -p "$work/system/usr/bin/hbil" | grep -E 'R(UN)?PATH' >"$work/out"
    ok $? "the packaged program looks for libraries in no place of its own"
    LD_LIBRARY_PATH=$(dirname "$work"/system/usr/lib/*/libhbil.so.1)
    says "and runs" "^hbil $version\$" "$work/system/usr/bin/hbil" --version
    name="so does Python's package"
    if /usr/bin/python3 -c 'import cffi, numpy' 2>/dev/null; then
      says "$name" "^$version\$" env \
        "PYTHONPATH=$work/system/usr/lib/python3/dist-packages" \
        /usr/bin/python3 -c 'import hbil; print(hbil.version())'
    else
      skip "$name" "no python3 with cffi and numpy"
    fi
  else
    skip "$name" "$(head -n 1 "$work/out" | sed 's/.*error: //')"
  fi
fi

echo "1..$count"
