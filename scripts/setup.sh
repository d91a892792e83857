#!/usr/bin/env bash
# Installs the Debian packages that are missing; does nothing, quickly, where all are there.
#
#   scripts/setup.sh            what building the program needs
#   scripts/setup.sh test       the tests' packages as well
#   scripts/setup.sh test fuzz  and those of the fuzz targets
#   scripts/setup.sh plugins    what all plug-ins need; the ID of one, such as dicom or vtk ('isoextract formats' lists them):
#                               what that one needs; scripts/run asks for it where it is needed
#   scripts/setup.sh bench      what building the program needs, and what it is compared with
#   scripts/setup.sh measure    what scripts/measure needs: the packages of bench, and more programs to compare with
#   scripts/setup.sh blender    what scripts/blender/check needs besides the program
#   scripts/setup.sh viewers    what scripts/check_in_viewers.py and scripts/compare_verdicts.py need: Blender, MeshLab, slicers
#   scripts/setup.sh cluster    what scripts/cluster/try_slurm needs: Slurm, and GNU parallel
set -euo pipefail

# libepoxy-dev is for the GPU backend, and the Mesa packages after it let it run where there is no GPU.
build_packages=(
  g++ cmake ninja-build pkg-config
  libtbb-dev libimath-dev libblosc-dev libopenexr-dev libpng-dev
  libteem-dev libnifti2-dev zlib1g-dev
  libtinygltf-dev nlohmann-json3-dev libdraco-dev libmeshoptimizer-dev
  libepoxy-dev libegl1 libopengl0 libegl-mesa0 libgl1-mesa-dri
  libxxhash-dev libglm-dev libhwy-dev libcli11-dev libtomlplusplus-dev libfmt-dev libspdlog-dev libexpected-dev
)
# OpenVDB writes the VDB files that the tests read. Its headers include Boost's; its package does not say so. dpkg-dev
# unpacks the source of oneTBB (scripts/tsan_tbb).
test_packages=(
  libgtest-dev libopenvdb-dev libboost-dev clang-format clang-tidy python3 python3-jsonschema python3-numpy
  python3-pandas jq libopenvdb-tools shellcheck mandoc bash-completion zsh fish gnuplot-nox dpkg-dev zstd
  libgdcm-tools python3-pil python3-tifffile python3-h5py python3-netcdf4 python3-segyio python3-pydicom
  admesh python3-scipy python3-zarr python3-numcodecs python3-mrcfile ferret-datasets
)
fuzz_packages=(clang libclang-rt-14-dev)
# Packages by the ID of the plug-in, which is the name of its folder in plugins.
declare -A plugin_packages=(
  [archive]="libarchive-dev"
  [dicom]="libgdcm-dev"
  [hdf5]="libhdf5-dev"
  [images]="libtiff-dev libopenexr-dev libpng-dev"
  [mpi]="libopenmpi-dev openmpi-bin"
  [netcdf]="libnetcdf-dev"
  [openvdb]="libopenvdb-dev libboost-dev"
  [segy]="libsegyio-dev"
  [vtk]="libvtk9-dev"
  [zarr]="libminizip-dev libblosc-dev libzstd-dev liblz4-dev libbz2-dev liblzma-dev"
)
bench_packages=(libvtk9-dev libopenvdb-dev libboost-dev libimath-dev libopenvdb-tools python3)
# Building the random fields needs the packages of the tests' CMake files. mmdebstrap is for scripts/measuring/newer_vtk.
measure_packages=(
  gnuplot-nox libgtest-dev python3-numpy python3-scipy python3-vtk9 python3-skimage mmdebstrap
  admesh prusa-slicer meshlab xvfb xauth
)

# Not part of scripts/test: too large.
blender_packages=(blender python3 python3-numpy)
viewers_packages=("${blender_packages[@]}" python3-scipy meshlab xvfb xauth admesh prusa-slicer)
cluster_packages=(slurm-wlm munge parallel)

say() { printf 'setup: %s\n' "$*" >&2; }

wanted=("${build_packages[@]}")
# Any node and npm on the PATH will do: another vendor's nodejs brings its own npm and conflicts with Debian's.
want_node() {
  command -v node >/dev/null || wanted+=(nodejs)
  command -v npm >/dev/null || wanted+=(npm)
}
for group in "$@"; do
  case $group in
    build) ;;
    test)
      wanted+=("${test_packages[@]}")
      want_node
      ;;
    fuzz) wanted+=("${fuzz_packages[@]}") ;;
    bench) wanted+=("${bench_packages[@]}") ;;
    measure)
      wanted+=("${bench_packages[@]}" "${measure_packages[@]}")
      want_node
      ;;
    blender) wanted+=("${blender_packages[@]}") ;;
    viewers) wanted+=("${viewers_packages[@]}") ;;
    cluster) wanted+=("${cluster_packages[@]}") ;;
    plugins)
      for packages in "${plugin_packages[@]}"; do
        read -r -a named <<<"$packages"
        wanted+=("${named[@]}")
      done
      ;;
    *)
      if [ -z "${plugin_packages[$group]-}" ]; then
        say "unknown group '$group': expected build, test, fuzz, plugins, bench, measure, blender, viewers, cluster, or a"
        say "plug-in: $(printf '%s\n' "${!plugin_packages[@]}" | sort | paste -sd ' ')"
        exit 1
      fi
      read -r -a named <<<"${plugin_packages[$group]}"
      wanted+=("${named[@]}")
      ;;
  esac
done

if ! command -v dpkg-query >/dev/null; then
  say "no dpkg here, so nothing is checked or installed; on Debian 12 these packages are used: ${wanted[*]}"
  exit 0
fi

# dpkg-query fails if it does not know a package, but still lists the others.
installed=$(dpkg-query -W -f '${db:Status-Status} ${binary:Package}\n' "${wanted[@]}" 2>/dev/null |
  sed -n 's/^installed \([^:]*\).*/\1/p' || true)
missing=()
for package in "${wanted[@]}"; do
  grep -qxF -e "$package" <<<"$installed" || missing+=("$package")
done
[ ${#missing[@]} -gt 0 ] || exit 0

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    say "these packages are missing, and without root or sudo they cannot be installed; run as root:"
    say "  apt-get install --no-install-recommends ${missing[*]}"
    exit 1
  fi
  as_root=(sudo)
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 "$@" </dev/null >"$log" 2>&1
}

say "installing ${#missing[@]} Debian packages: ${missing[*]}"
if ! apt update; then
  say "apt-get update failed; once more"
  sleep 5
  apt update || say "apt-get update failed again; going on with the package lists that are here"
fi
if ! apt install -y --no-install-recommends "${missing[@]}"; then
  tail -n 30 "$log" >&2
  say "apt-get install failed; its last lines are above"
  exit 1
fi
