// Makes a plan from the options of `isoextract render`. Opens only these inputs: standard input (is it a mesh?), a
// volume that may name its labels, tables of labels, and the files that batch::find_frames() opens.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "base/note.hpp"
#include "batch/frame_range.hpp"
#include "cli/options.hpp"
#include "convert/backends.hpp"
#include "convert/conversion_job.hpp"
#include "render/camera.hpp"
#include "render/renderer.hpp"

namespace isoextract::cli {

struct PicturePlan {
  std::int64_t frame = 0;
  std::optional<std::string> input;  // the volume; unset if there are only meshes
  double turn = 0;                   // rotation of the camera in degrees; 0 in a sequence
  std::string output;                // a path, or "-"
};

struct RenderPlan {
  MemoryBudget memory;
  std::vector<PicturePlan> pictures;      // at least one: the frames of a sequence, or the views of a turn of one input
  bool is_sequence = false;               // pictures of several frames of volumes
  bool has_radius_of_each_frame = false;  // --radius auto:each
  std::vector<batch::FrameRun> missing;   // frames of --frames without an input
  // How to read volumes and extract their surfaces; without input and outputs.
  convert::ConversionJob job;
  std::vector<convert::IsoChoice> isos;
  std::vector<std::string> meshes;
  std::vector<glm::dvec3> mesh_colors;  // linear; one per mesh, or one for all; empty: colors of the files
  std::vector<double> opacity;          // of surfaces, then meshes: one each, or one for all; empty: default
  render::Shading shading = render::Shading::smooth;
  bool draws_volume = true;
  std::optional<std::string> transfer_file;
  render::BuiltInTransfer transfer = render::BuiltInTransfer::gray;
  std::optional<std::array<double, 2>> transfer_range;
  std::optional<double> unit_length;  // see render::Volume::unit_length
  std::optional<EmissionChoice> emission;
  render::ViewAngles camera;
  double fovy = render::Camera::kDefaultFovy;  // vertical field of view in radians
  // Default: y if all inputs are meshes whose placement records state y up, otherwise z.
  std::optional<render::UpAxis> up;
  render::RenderOptions options;
  std::optional<int> rays_across;  // rays of a pixel along each axis; default: 1 for volumes alone, else 2
  glm::dvec4 background{0.0};
  convert::Backend backend = convert::Backend::automatic;
  gpu::GpuChoice gpu;
  std::optional<std::string> json;
  Notes notes;
};

// Plans a rendering. Reads the start of standard input if that is an input. Fails with ErrorCode::usage for options
// that contradict each other or have no effect. Also fails as batch::find_frames(), batch::name_outputs() and
// volume_io::LabelTable::read() do.
[[nodiscard]] Result<RenderPlan> plan_render(const RenderFlags& flags);

// The format of a picture file.
enum class PictureFile { png, exr };
constexpr auto words_of(PictureFile /*type*/) {
  return std::array{Word{PictureFile::png, "png"}, Word{PictureFile::exr, "exr"}};
}
// Returns the format by the extension, ignoring case; png for "-"; nullopt for other extensions.
[[nodiscard]] std::optional<PictureFile> picture_file_of(const std::string& path);

}  // namespace isoextract::cli
