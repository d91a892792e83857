// Makes plans from flags: applies defaults and checks combinations. Opens no file, except an input that may hold
// particles, since these have their own default iso value.
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

// The documents about a conversion or a batch.
struct PagesPlan {
  std::optional<std::string> html;
  std::optional<std::string> contact_sheet;

  [[nodiscard]] bool any() const { return html || contact_sheet; }
};

struct ConvertPlan {
  convert::ConversionJob job;
  Context context;  // for everything that the conversion reads
  std::optional<int> threads;
  Verbosity verbosity = Verbosity::normal;
  bool explain = false;
  std::optional<std::string> report;  // the path of the JSON report
  bool make_folders = false;          // makes missing folders of outputs
  PagesPlan pages;
  std::optional<std::string> on_side_text;  // describes the output if the volume's up axis is not the default
  std::vector<std::string> notes;           // options without an effect, one sentence each
};

struct InfoPlan {
  MemoryBudget memory;
  std::vector<std::string> inputs;
  std::optional<batch::FrameRange> frames;  // for a sequence
  volume_io::ReadOptions read;
  convert::ParticleOptions particles;
  std::vector<std::string> input_arguments;  // the input options as given, for the example command
  bool json = false;
};

struct VerifyPlan {
  Context context;
  convert::ConversionJob job;       // the conversion that should have made the mesh; its only output is that mesh
  std::optional<std::string> mesh;  // if unset, compares the backends
  bool is_placed = false;           // placement options are given, so the mesh's own placement is ignored
  bool float32_world = false;       // the mesh's format stores only float32 world coordinates
  bool json = false;
  std::vector<std::string> notes;
};

struct ComparePlan {
  std::array<std::string, 2> meshes;
  std::optional<convert::UpAxis> up;  // up axis of the mesh that is not glTF, if the other one is; default z
  std::optional<double> max_distance;
  MemoryBudget memory;
  bool json = false;
};

struct BenchPlan {
  MemoryBudget memory;
  std::vector<std::string> inputs;
  bool gpu_threads = false;                           // measures GPU threads instead of inputs
  std::optional<std::vector<NamedBackend>> backends;  // default: cpu, and gpu unless it renders in software
  gpu::GpuChoice gpu;                                 // for the default backends
  volume_io::ReadOptions read;
  std::optional<double> iso;    // default: that of each demo field
  std::vector<int> sizes;       // for demo fields
  std::vector<int> coarser;     // coarsening factors for files, descending, without 1; empty: chosen by size
  bench::BenchOptions options;  // all except iso and backends
  std::optional<std::string> csv;
  std::optional<std::string> json;
  std::optional<std::string> plot;
  PictureFormat picture = PictureFormat::svg;
};

// The end of the note that relaxing changed volumes.
inline constexpr std::string_view kHowToKeepVolumes = ": --relax 0 keeps the volumes of the voxels";

// Plans --device and --gpu-memory.
[[nodiscard]] gpu::GpuChoice plan_gpu(const DeviceFlags& flags);
// Applies --device and --gpu-memory to each backend of a list.
[[nodiscard]] std::vector<NamedBackend> plan_backends(std::vector<NamedBackend> backends, const DeviceFlags& flags);
[[nodiscard]] Result<Verbosity> plan_verbosity(const RunFlags& flags);
[[nodiscard]] Result<ConvertPlan> plan_convert(const ConvertFlags& flags);
// Does not handle --inside away-from-zero: the caller puts it into SourceOptions, or calls refuse_away_from_zero().
[[nodiscard]] Result<volume_io::ReadOptions> plan_read(const InputFlags& flags);
// For commands that read one grid.
[[nodiscard]] Result<void> refuse_several_grids(const InputFlags& flags, std::string_view command);
// For commands without iso values, which cannot orient each surface by its iso value.
[[nodiscard]] Result<void> refuse_away_from_zero(const InputFlags& flags, std::string_view command);
// Plans everything except the files: the job has no input and no outputs. `isos` are the iso values of the first input;
// `context` becomes the plan's.
[[nodiscard]] Result<ConvertPlan> plan_conversion(const ConvertFlags& flags,
                                                  const std::vector<convert::IsoChoice>& isos, const Context& context);
// Finds the format by the extension.
[[nodiscard]] Result<PictureFormat> picture_format_of(const std::string& path);
// For options that plan_convert() refuses: returns one job per input, at least one, with only the files that the
// options name.
[[nodiscard]] std::vector<convert::ConversionJob> plan_named_files(const ConvertFlags& flags);
[[nodiscard]] Result<BenchPlan> plan_bench(const BenchFlags& flags);
[[nodiscard]] Result<InfoPlan> plan_info(const InfoFlags& flags);
[[nodiscard]] Result<VerifyPlan> plan_verify(const VerifyFlags& flags);
[[nodiscard]] Result<ComparePlan> plan_compare(const CompareFlags& flags);

}  // namespace isoextract::cli
