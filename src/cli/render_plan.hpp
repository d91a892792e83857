// Makes a plan from the options of `isoextract render`. Reads folders if inputs are frames. Opens no file except
// standard input, whose content tells whether it is a mesh.
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
  double turn = 0;                   // rotation of the camera in degrees
  std::string output;                // a path, or "-"
};

struct RenderPlan {
  MemoryBudget memory;
  std::vector<PicturePlan> pictures;     // at least one; those of a turn are consecutive and share an input
  bool is_sequence = false;              // pictures of several frames of volumes
  std::vector<batch::FrameRun> missing;  // requested frames without an input
  // How to read volumes and extract their surfaces; without input and outputs.
  convert::ConversionJob job;
  std::vector<convert::IsoChoice> isos;
  std::vector<std::string> meshes;
  std::vector<glm::dvec3> mesh_colors;  // linear; one per mesh, or one for all; empty: their own colors
  std::vector<double> opacity;          // of surfaces, then meshes: one each, or one for all; empty: opaque
  render::Shading shading = render::Shading::smooth;
  bool draws_volume = true;
  std::optional<std::string> transfer_file;
  render::BuiltInTransfer transfer = render::BuiltInTransfer::gray;
  std::optional<std::array<double, 2>> transfer_range;
  std::optional<double> unit_length;
  render::ViewAngles camera;
  double fovy = render::Camera::kDefaultFovy;
  std::optional<render::UpAxis> up;  // default: y if all inputs are meshes with y up, otherwise z
  render::RenderOptions options;
  glm::dvec4 background{0.0};
  convert::Backend backend = convert::Backend::automatic;
  gpu::GpuChoice gpu;
  std::optional<std::string> json;
  Notes notes;
};

[[nodiscard]] Result<RenderPlan> plan_render(const RenderFlags& flags);

// The format of a picture file, by its extension.
enum class PictureFile { png, exr };
constexpr auto words_of(PictureFile /*type*/) {
  return std::array{Word{PictureFile::png, "png"}, Word{PictureFile::exr, "exr"}};
}
[[nodiscard]] std::optional<PictureFile> picture_file_of(const std::string& path);

}  // namespace isoextract::cli
