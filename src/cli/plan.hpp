// From flags to a plan: defaults applied, combinations checked. Nothing is opened here, but an input of which it has to
// be known whether it is of particles, for these have an iso value of their own.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "cli/error_plot.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

// What is written about a conversion, or all frames of it, besides its meshes.
struct PagesPlan {
  std::optional<std::string> html;
  std::optional<std::string> contact_sheet;

  [[nodiscard]] bool any() const { return html || contact_sheet; }
};

struct ConvertPlan {
  convert::ConversionJob job;
  Context context;  // of all that is read for it
  std::optional<int> threads;
  Verbosity verbosity = Verbosity::normal;
  bool explain = false;
  std::optional<std::string> report;  // the path of the JSON report
  bool make_folders = false;          // of the outputs, where they are not there
  PagesPlan pages;
  std::optional<std::string> if_on_side;  // what is wrong with the output where another axis is up than the default
  std::vector<std::string> notes;         // what was asked for and changes nothing, one sentence each
};

struct InfoPlan {
  MemoryBudget memory;
  std::vector<std::string> inputs;
  std::optional<batch::FrameRange> frames;  // of a sequence
  volume_io::ReadOptions read;
  convert::ParticleOptions particles;
  std::vector<std::string> input_arguments;  // the input options as they were given, to repeat in an example
  bool json = false;
};

struct VerifyPlan {
  Context context;
  convert::ConversionJob job;       // what the mesh is to be as if made by; its one output is that mesh
  std::optional<std::string> mesh;  // none: the backends are compared
  bool is_placed = false;           // by options: what the mesh says of its placement does not count then
  bool float32_world = false;       // the mesh's format has float32 world coordinates only
  bool json = false;
  std::vector<std::string> notes;
};

struct ComparePlan {
  std::array<std::string, 2> meshes;
  std::optional<convert::UpAxis> up;  // in the mesh that is not glTF, where the other is; none: z
  std::optional<double> max_distance;
  MemoryBudget memory;
  bool json = false;
};

struct BenchPlan {
  MemoryBudget memory;
  std::vector<std::string> inputs;
  bool gpu_threads = false;                           // instead of inputs
  std::optional<std::vector<NamedBackend>> backends;  // none: cpu, and gpu where there is one that is not software
  gpu::GpuChoice gpu;                                 // of the default
  volume_io::ReadOptions read;
  std::optional<double> iso;    // none: each demo field's own
  std::vector<int> sizes;       // of demo fields
  std::vector<int> coarser;     // of files, falling, without 1; empty: as far as they allow
  bench::BenchOptions options;  // without iso and backends
  std::optional<std::string> csv;
  std::optional<std::string> json;
  std::optional<std::string> plot;
  PictureFormat picture = PictureFormat::svg;
};

// Ends the note that relaxing changed volumes.
inline constexpr std::string_view kHowToKeepVolumes = ": --relax 0 keeps the volumes of the voxels";

// What --device and --gpu-memory say.
[[nodiscard]] gpu::GpuChoice plan_gpu(const DeviceFlags& flags);
// The same for each backend of a list.
[[nodiscard]] std::vector<NamedBackend> plan_backends(std::vector<NamedBackend> backends, const DeviceFlags& flags);
[[nodiscard]] Result<Verbosity> plan_verbosity(const RunFlags& flags);
[[nodiscard]] Result<ConvertPlan> plan_convert(const ConvertFlags& flags);
// --inside away-from-zero is left to who makes a SourceOptions of the flags, or to refuse_two_sides().
[[nodiscard]] Result<volume_io::ReadOptions> plan_read(const InputFlags& flags);
// For the commands that read one grid.
[[nodiscard]] Result<void> refuse_several_grids(const InputFlags& flags, std::string_view command);
// For the commands that have no iso values of their own to turn each surface by.
[[nodiscard]] Result<void> refuse_two_sides(const InputFlags& flags, std::string_view command);
// All of it but which files are read and written: the job's input is empty, and it has no outputs. `isos` are
// those of the first input, and `context` becomes the plan's.
[[nodiscard]] Result<ConvertPlan> plan_conversion(const ConvertFlags& flags,
                                                  const std::vector<convert::IsoChoice>& isos, const Context& context);
// By the extension of a picture's name.
[[nodiscard]] Result<PictureFormat> picture_format_of(const std::string& path);
// Of options that make no plan: what they name all the same, as a job an input with its files and nothing else. There
// is one at least.
[[nodiscard]] std::vector<convert::ConversionJob> plan_files(const ConvertFlags& flags);
[[nodiscard]] Result<BenchPlan> plan_bench(const BenchFlags& flags);
[[nodiscard]] Result<InfoPlan> plan_info(const InfoFlags& flags);
[[nodiscard]] Result<VerifyPlan> plan_verify(const VerifyFlags& flags);
[[nodiscard]] Result<ComparePlan> plan_compare(const CompareFlags& flags);

}  // namespace isoextract::cli
