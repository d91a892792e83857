// From the options of `isoextract render` to what is drawn. Folders are read where inputs are frames; no file is
// opened but standard input, of which only the content says whether it is a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "batch/frame_range.hpp"
#include "cli/options.hpp"
#include "convert/backends.hpp"
#include "convert/conversion_job.hpp"
#include "render/camera.hpp"
#include "render/renderer.hpp"

namespace isoextract::cli {

struct PicturePlan {
  std::int64_t frame = 0;
  std::optional<std::string> input;  // the volume; none: there are meshes only
  double turn = 0;                   // degrees that the camera has gone around
  std::string output;                // a path, or "-"
};

struct RenderPlan {
  MemoryBudget memory;
  std::vector<PicturePlan> pictures;     // at least one; those of a turn follow each other with one input
  bool is_sequence = false;              // of volumes, by their frames
  std::vector<batch::FrameRun> missing;  // frames that were asked for and are not there
  // How volumes are read, and their surfaces extracted: without an input and without outputs.
  convert::ConversionJob job;
  std::vector<convert::IsoChoice> isos;
  std::vector<std::string> meshes;
  std::vector<glm::dvec3> mesh_colours;  // linear; of meshes in their order, or one for all; none: their own
  std::vector<double> opacity;           // of surfaces and then meshes: one for each, or one for all, or none: opaque
  render::Shading shading = render::Shading::smooth;
  bool draws_volume = true;
  std::optional<std::string> transfer_file;
  render::BuiltInTransfer transfer = render::BuiltInTransfer::grey;
  std::optional<std::array<double, 2>> transfer_range;
  std::optional<double> unit_length;
  render::ViewAngles camera;
  double fovy = render::Camera::kDefaultFovy;
  std::optional<render::UpAxis> up;  // none: y where all that is drawn are meshes that say so, and z else
  render::RenderOptions options;
  glm::dvec4 background{0.0};
  convert::Backend backend = convert::Backend::automatic;
  gpu::GpuChoice gpu;
  std::optional<std::string> json;
  std::vector<std::string> notes;
};

[[nodiscard]] Result<RenderPlan> plan_render(const RenderFlags& flags);

// Of a picture's name.
enum class PictureFile { png, exr };
constexpr auto words_of(PictureFile /*type*/) {
  return std::array{Word{PictureFile::png, "png"}, Word{PictureFile::exr, "exr"}};
}
[[nodiscard]] std::optional<PictureFile> picture_file_of(const std::string& path);

}  // namespace isoextract::cli
