// Turns parsed options into the validated settings of convert, info, verify, compare and bench; other commands have a
// header of their own (batch_plan.hpp, check_plan.hpp, ...). Opens tables of labels, and the input of convert and
// verify, whose content (a mesh, particles, named labels, integers) decides the defaults. Functions that refuse options
// fail with ErrorCode::usage.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/memory_budget.hpp"
#include "base/note.hpp"
#include "cli/error_plot.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {

// The HTML page and the contact sheet that show the results.
struct PagesPlan {
  std::optional<std::string> html;           // path
  std::optional<std::string> contact_sheet;  // path
  convert::PictureFileOptions view = {};     // how to draw the meshes
  bool has_usual_size = true;  // --size is not given: the page and the sheet have default sizes, not that of `view`

  [[nodiscard]] bool any() const { return html || contact_sheet; }
};

struct ConvertPlan {
  convert::ConversionJob job;
  Context context;  // memory limit and cancellation of the conversion
  std::optional<int> threads;
  MessageChoice shown;
  bool explain = false;
  std::optional<std::string> report;  // the path of the JSON report
  bool make_folders = false;          // makes missing folders of outputs
  PagesPlan pages;
  // The `consequence` of up_axis_note(): "the mesh lies on its side". Unset if --up is given or if the output does not
  // depend on the up axis.
  std::optional<std::string> on_side_text;
  Notes notes;  // notes about the options, one sentence each
};

struct InfoPlan {
  MemoryBudget memory;
  std::vector<std::string> inputs;
  std::optional<batch::FrameRange> frames;  // the frames of a sequence to read; default: all
  volume_io::ReadOptions read;
  convert::ParticleOptions particles;
  bool has_radius_of_each_frame = false;  // --radius auto:each
  std::vector<std::string> masks;         // with --masks: the mask files of all inputs
  Notes notes;
  std::vector<std::string> input_arguments;  // options of inputs and particles as given, for the example command
  bool json = false;
};

struct VerifyPlan {
  Context context;
  convert::ConversionJob job;       // the conversion that made the mesh, with the mesh as its only output
  std::optional<std::string> mesh;  // unset: verify compares the backends
  bool is_placed = false;           // placement options are given and replace the mesh's own placement
  bool float32_world = false;       // the mesh's format stores only float32 world coordinates
  bool json = false;
  Notes notes;
};

struct ComparePlan {
  std::array<std::string, 2> meshes;
  std::optional<convert::UpAxis> up;  // up axis of the non-glTF mesh if the other mesh is glTF; default z
  std::optional<double> max_distance;
  MemoryBudget memory;
  bool json = false;
};

struct BenchPlan {
  MemoryBudget memory;
  std::vector<std::string> inputs;
  bool gpu_threads = false;                           // bench gpu-threads: times the creation of GPU threads
  std::optional<std::vector<NamedBackend>> backends;  // default: cpu, and gpu unless it renders in software
  gpu::GpuChoice gpu;                                 // of the default backends and of bench gpu-threads
  volume_io::ReadOptions read;
  std::optional<double> iso;    // default: the iso value of each demo field
  std::vector<int> sizes;       // for demo fields and bench gpu-threads
  std::vector<int> coarser;     // coarsening factors for files, descending, without 1; empty: chosen by size
  bench::BenchOptions options;  // all except iso and backends
  std::optional<std::string> csv;
  std::optional<std::string> json;
  std::optional<std::string> plot;
  PictureFormat picture = PictureFormat::svg;
};

// Ends the note about volumes that --relax changed.
inline constexpr std::string_view kHowToKeepVolumes = ": --relax 0 keeps the volumes of the voxels";

// Returns the GPU that --device and --gpu-memory choose.
[[nodiscard]] gpu::GpuChoice plan_gpu(const DeviceFlags& flags);
// Applies --device and --gpu-memory to each backend of a list.
[[nodiscard]] std::vector<NamedBackend> plan_backends(std::vector<NamedBackend> backends, const DeviceFlags& flags);
[[nodiscard]] Result<MessageChoice> plan_messages(const RunFlags& flags);
[[nodiscard]] Result<ConvertPlan> plan_convert(const ConvertFlags& flags);
// Does not handle --inside away-from-zero: the caller puts it into SourceOptions, or calls refuse_away_from_zero().
[[nodiscard]] Result<volume_io::ReadOptions> plan_read(const InputFlags& flags);
// Refuses several grids; for commands that read one grid.
[[nodiscard]] Result<void> refuse_several_grids(const InputFlags& flags, std::string_view command);
// Refuses --inside away-from-zero; for info and bench, which do not support it.
[[nodiscard]] Result<void> refuse_away_from_zero(const InputFlags& flags, std::string_view command);
// Plans everything except the files: the job has no input and no outputs. `isos` are the iso values of the first input;
// `context` is stored in the plan.
[[nodiscard]] Result<ConvertPlan> plan_conversion(const ConvertFlags& flags,
                                                  const std::vector<convert::IsoChoice>& isos, const Context& context);
// Returns svg or png by the extension of `path`. Fails with ErrorCode::usage for other extensions.
[[nodiscard]] Result<PictureFormat> picture_format_of(const std::string& path);
// Returns the input and output paths that options name, as one job per input and at least one job. Used if
// plan_convert() fails: the report of the failure must not overwrite these files.
[[nodiscard]] std::vector<convert::ConversionJob> plan_named_files(const ConvertFlags& flags);
[[nodiscard]] Result<BenchPlan> plan_bench(const BenchFlags& flags);
[[nodiscard]] Result<InfoPlan> plan_info(const InfoFlags& flags);
[[nodiscard]] Result<VerifyPlan> plan_verify(const VerifyFlags& flags);
[[nodiscard]] Result<ComparePlan> plan_compare(const CompareFlags& flags);

}  // namespace isoextract::cli
