#include "cli/wrong_file_kind.hpp"

#include <filesystem>
#include <utility>

#include <fmt/format.h>

#include "cli/values.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "particle_io/particle_format.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

// Missing and empty files have no kind.
bool has_content(const std::string& path) {
  std::error_code none;
  return fs::is_regular_file(path, none) && fs::file_size(path, none) > 0;
}

}  // namespace

Error add_mesh_file_hint(Error error, const std::string& path) {
  const bool is_mesh = mesh_io::mesh_format_by_path(path).has_value();
  const bool is_named = volume_io::has_volume_extension(path) || particle_io::has_particle_extension(path);
  if (error.code != ErrorCode::input || !error.hint.empty() || is_mesh || !has_content(path) || !is_named) return error;
  error.hint = fmt::format("the file name is that of a volume or of particles: 'isoextract info {}' shows the content",
                           shell_quoted(path));
  return error;
}

Error add_volume_file_hint(Error error, const std::string& path) {
  std::error_code none;
  if (error.hint.empty() && fs::is_directory(path, none)) {
    error.hint = "give one of the files in the folder; only a conversion takes a folder, as a sequence";
    return error;
  }
  if (error.code != ErrorCode::input || !has_content(path) || !mesh_io::find_mesh_format(path, Context())) return error;
  error.hint =
      fmt::format("the file is a mesh: 'isoextract check {0}' reports on it, 'isoextract {0} -o OUT.glb' converts it",
                  shell_quoted(path));
  return error;
}

}  // namespace isoextract::cli
