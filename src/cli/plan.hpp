// From flags to a plan: defaults applied, combinations checked. Nothing is opened here.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/limits.hpp"
#include "cli/error_plot.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"
#include "cli/placement.hpp"
#include "meshes/mesh_writer.hpp"
#include "volumes/volume_reader.hpp"

namespace isoextract::cli {

// One file to write, and the surfaces in it.
struct OutputJob {
  std::string path;  // "-" is stdout
  std::vector<double> isos;
};

struct ConvertPlan {
  std::string input;
  volumes::ReadOptions read;
  Limits limits = default_limits();
  extract::ExtractOptions extract;  // without iso, region and placement, which depend on the surface and the field
  std::optional<field::Box> roi;
  std::optional<glm::ivec3> resolution;  // of the grid to extract from, in place of the input's own samples
  std::optional<SimplifyError> simplify;
  EmptyPolicy empty = EmptyPolicy::error;
  Placement placement;
  meshes::MeshWriteOptions write;
  std::vector<OutputJob> jobs;
  BackendChoice backend;
  std::optional<field::Interpolation> error;  // to measure the mesh against
  bool verify = false;
  bool explain = false;
  std::optional<std::string> report;   // the path of the JSON report
  std::vector<std::string> arguments;  // the words of the command line, for the report
  std::vector<std::string> notes;      // what was asked for and changes nothing, one sentence each
};

struct InfoPlan {
  std::vector<std::string> inputs;
  volumes::ReadOptions read;
  Limits limits = default_limits();
  std::vector<std::string> input_arguments;  // the input options as they were given, to repeat in an example
  bool json = false;
};

struct VerifyPlan {
  std::string input;
  std::optional<std::string> mesh;  // none: the backends are compared
  volumes::ReadOptions read;
  Limits limits = default_limits();
  extract::ExtractOptions extract;  // without region and placement, which depend on the field
  std::optional<field::Box> roi;
  std::optional<glm::ivec3> resolution;
  Placement placement;
  gpu::GpuOptions gpu;
  bool float32_world = false;  // the mesh's format has float32 world coordinates only
  bool json = false;
  std::vector<std::string> notes;
};

struct ComparePlan {
  std::array<std::string, 2> meshes;
  std::optional<double> max_distance;
  Limits limits = default_limits();
  bool json = false;
};

struct BenchPlan {
  std::vector<std::string> inputs;
  bool gpu_threads = false;                           // instead of inputs
  std::optional<std::vector<NamedBackend>> backends;  // none: cpu, and gpu where there is one that is not software
  gpu::GpuOptions gpu;                                // of the default
  volumes::ReadOptions read;
  Limits limits = default_limits();
  std::optional<double> iso;      // none: each demo field's own
  std::vector<int> sizes;         // of demo fields
  std::vector<int> coarser;       // of files, falling, without 1; empty: as far as they allow
  measure::BenchOptions options;  // without iso and backends
  std::optional<std::string> csv;
  std::optional<std::string> json;
  std::optional<std::string> plot;
  PictureFormat picture = PictureFormat::svg;
};

// What --device and --gpu-memory say.
[[nodiscard]] gpu::GpuOptions plan_gpu(const DeviceFlags& flags);
// The same for each backend of a list.
[[nodiscard]] std::vector<NamedBackend> plan_backends(std::vector<NamedBackend> backends, const DeviceFlags& flags);
[[nodiscard]] Result<Verbosity> plan_verbosity(const RunFlags& flags);
[[nodiscard]] Result<ConvertPlan> plan_convert(const ConvertFlags& flags);
[[nodiscard]] Result<BenchPlan> plan_bench(const BenchFlags& flags);
[[nodiscard]] Result<InfoPlan> plan_info(const InfoFlags& flags, const CLI::App& command);
[[nodiscard]] Result<VerifyPlan> plan_verify(const VerifyFlags& flags);
[[nodiscard]] Result<ComparePlan> plan_compare(const CompareFlags& flags);

// "scan.nii.gz" -> "scan", "demo:torus?size=32" -> "torus"
[[nodiscard]] std::string input_stem(const std::string& input);

}  // namespace isoextract::cli
