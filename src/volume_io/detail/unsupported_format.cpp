#include "volume_io/detail/unsupported_format.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/ascii.hpp"

namespace isoextract::volume_io {
namespace {

using std::string_view_literals::operator""sv;

// Bytes of a format's signature at an offset.
struct Magic {
  std::size_t offset;
  std::string_view bytes;
};

struct UnsupportedFormatEntry {
  std::string_view title;
  std::vector<std::string_view> extensions;
  std::vector<Magic> magics;
  std::string_view way;
};

const std::vector<UnsupportedFormatEntry>& known_unread() {
  static const std::vector<UnsupportedFormatEntry> known{
      {"a FreeSurfer volume", {".mgz", ".mgh"}, {}, "mri_convert makes a NIfTI file of it"},
      {"a MINC volume", {".mnc"}, {}, "mnc2nii makes a NIfTI file of it"},
      {"an AFNI volume", {".head", ".brik", ".brik.gz"}, {}, "3dAFNItoNIFTI makes a NIfTI file of it"},
      {"an INRIMAGE file",
       {".inr", ".inr.gz"},
       {{0, "#INRIMAGE"}},
       "its samples follow a header of a multiple of "
       "256 bytes: read it as a raw file"},
      {"a NanoVDB file", {".nvdb"}, {{0, "NanoVDB"}}, "nanovdb_convert makes a VDB file of it"},
      {"a Field3D file", {".f3d"}, {}, "Houdini and Field3D's own tools make a VDB file of it"},
      {"an Alembic file", {".abc"}, {{0, "Ogawa"}}, "Houdini and Blender read it, and write VDB files or PLY points"},
      {"a Blender particle cache", {".bphys"}, {{0, "BPHYSICS"}}, "Blender writes its particles as PLY points"},
      {"an Exodus II file",
       {".e", ".exo", ".ex2", ".exii"},
       {},
       "ParaView resamples it to an image, whose arrays numpy.save stores as NPY"},
      {"a MATLAB file",
       {".mat"},
       {{0, "MATLAB "}},
       "scipy.io.loadmat or h5py, and numpy.save, make an NPY array of it"},
  };
  return known;
}

bool begins_with(std::span<const std::byte> start, const Magic& magic) {
  if (start.size() < magic.offset || start.size() - magic.offset < magic.bytes.size()) return false;
  return std::ranges::equal(start.subspan(magic.offset, magic.bytes.size()), magic.bytes, {}, {},
                            [](char c) { return static_cast<std::byte>(c); });
}

// Arrays have no placement in the world, which most of these files have.
std::string way_of(const UnsupportedFormatEntry& format) {
  std::string way(format.way);
  if (way.find("NPY") != std::string::npos) way += "; then give its spacing and origin";
  return way;
}

}  // namespace

std::optional<UnsupportedFormat> find_unsupported_format(const std::filesystem::path& path,
                                                         std::span<const std::byte> start) {
  const std::string name = to_lower(path.filename().string());
  for (const UnsupportedFormatEntry& format : known_unread()) {
    const auto claims = [&](std::string_view extension) { return name.ends_with(extension); };
    if (std::ranges::any_of(format.extensions, claims))
      return UnsupportedFormat{std::string(format.title), true, way_of(format)};
  }
  for (const UnsupportedFormatEntry& format : known_unread()) {
    const auto is_it = [&](const Magic& magic) { return begins_with(start, magic); };
    if (std::ranges::any_of(format.magics, is_it))
      return UnsupportedFormat{std::string(format.title), false, way_of(format)};
  }
  return std::nullopt;
}

}  // namespace isoextract::volume_io
