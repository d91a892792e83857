#!/bin/sh
# Starts lib/isoextract on any x86-64 Linux machine. Written for scripts/portable, which puts it beside lib; needs no
# other program than this shell, and readlink where it is started through a link.
#
# Which libraries are this folder's, and which are the machine's:
#
# - Most are this folder's (lib).
# - A GPU's driver is always the machine's, because it has to fit the kernel. It runs in the same process, so it has to
#   get on with every library that it shares with the program. The rule for these libraries: the machine's own, if it has
#   every symbol version that the program asks for, and else this folder's, which then is the newer one. Either way the
#   driver and the program find no library older than the one they were built with. The rule applies to
#   - glibc (lib/glibc), with its loader, as one piece;
#   - what Mesa and its LLVM use too (lib/spare). Below the folder's own glibc these are the folder's as well.
# - EGL and OpenGL without a driver, that is GLVND (lib/egl, lib/opengl), come from here only where the machine has none.
#
# The loader itself is asked what it finds, for it alone knows its cache and configuration. The libraries' place
# is given to it and not put into LD_LIBRARY_PATH, which programs started from here (gnuplot) would inherit.
#
# ISOEXTRACT_LIBRARIES=bundled takes the folder's libraries in any case; GLVND and drivers stay the machine's.

fail() {
  printf 'isoextract: error: %s\n' "$1" >&2
  exit 3
}

self=$0
case $self in
  */*) ;;
  *) if [ -e "./$self" ]; then self=./$self; else self=$(command -v "$self"); fi ;;
esac
while [ -h "$self" ]; do
  link=$(readlink "$self") || fail "$self is a link, and readlink, which tells where to, is not there; start the file itself"
  case $link in
    /*) self=$link ;;
    *) self=${self%/*}/$link ;;
  esac
done
here=$(CDPATH='' cd -P "${self%/*}/" && pwd -P) || fail "the folder of $self cannot be found"
case $here in
  *[:\;\$]*) fail "the loader cannot find libraries in a folder with : or ; or \$ in its name: $here" ;;
esac

lib=$here/lib
program=$lib/isoextract
bundled=$lib/glibc/ld-linux-x86-64.so.2
host=/lib64/ld-linux-x86-64.so.2
graphics='libEGL.so.1 libOpenGL.so.0 libGLdispatch.so.0'
# Where the machine's libraries may be besides the loader's own places; NVIDIA's is for containers.
more=${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}:/usr/local/nvidia/lib64
spare=
for folder in "$lib"/spare/*; do spare=$spare:$folder; done

# What a loader finds in a path for the program and the graphics libraries; with this variable, as ldd sets it, the
# program is not run. A loader older than glibc 2.30 knows no --preload and fails; it is too old anyway.
list() { LD_TRACE_LOADED_OBJECTS=1 "$1" --library-path "$2" --preload "$graphics" "$program" 2>&1; }

# Uses the machine's glibc only if it suffices for all libraries of this folder that may be used.
loader=$bundled
path=$lib/glibc:$lib$spare
if [ "${ISOEXTRACT_LIBRARIES-}" != bundled ] && [ -x "$host" ] &&
  found=$(list "$host" "$lib$spare:$lib/egl:$lib/opengl$more"); then
  case $found in
    *'not found'*) ;;
    *'libc.so.6 => /'*) loader=$host path=$lib ;;
  esac
fi

found=$(list "$loader" "$path$more")
for folder in "$lib"/spare/*; do
  name=${folder##*/}
  case $found in
    *"/$name: version "*) path=$path:$folder ;; # there, but without a version that is needed
    *"$name => /"*) ;;
    *) path=$path:$folder ;;
  esac
done

case $found in
  *libc.musl*)
    # Drivers for another C library (Alpine) cannot be loaded into this process: none must be found.
    path=$path:$lib/egl:$lib/opengl
    export __EGL_VENDOR_LIBRARY_DIRS=/nonexistent
    ;;
  *'version `GLIBC_'*) path=$path:$lib/egl:$lib/opengl ;; # too new for this folder's glibc
  *'libEGL.so.1 => /'*)
    # OpenGL beside it only if it is GLVND's: without GLVND's libGLdispatch the two would know nothing of each other.
    case $found in
      *'libOpenGL.so.0 => /'*) ;;
      *'libGLdispatch.so.0 => /'*) path=$path:$lib/opengl ;;
    esac
    ;;
  *) path=$path:$lib/egl:$lib/opengl ;;
esac

# GLVND looks for drivers in the first two. The third is where containers get NVIDIA's.
nvidia=/usr/local/nvidia/share/glvnd/egl_vendor.d
if [ -z "${__EGL_VENDOR_LIBRARY_DIRS+set}${__EGL_VENDOR_LIBRARY_FILENAMES+set}" ] && [ -d "$nvidia" ]; then
  export __EGL_VENDOR_LIBRARY_DIRS="/etc/glvnd/egl_vendor.d:/usr/share/glvnd/egl_vendor.d:$nvidia"
fi

# The program looks for plug-ins beside itself, which is the loader here.
if [ -d "$lib/plugins" ]; then
  export ISOEXTRACT_PLUGINS="${ISOEXTRACT_PLUGINS:+$ISOEXTRACT_PLUGINS:}$lib/plugins"
fi

exec "$loader" --library-path "$path$more" "$program" "$@"
