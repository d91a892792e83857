// The one declaration of every command and option. Parsing, help, the man page and the completions all read it.
//
// Conventions that the documents rely on: a metavar with '|' in it ("mc|mt") lists all values; the metavars FILE and
// INPUT are completed with paths.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>
#include <glm/glm.hpp>

#include "base/words.hpp"
#include "batch/frame_range.hpp"
#include "batch/shard.hpp"
#include "cli/backends.hpp"
#include "cli/generate_docs.hpp"
#include "cli/values.hpp"
#include "convert/conversion_job.hpp"
#include "convert/placement.hpp"
#include "extract/extractor.hpp"
#include "field/interpolant.hpp"
#include "field/scalar_field.hpp"
#include "measure/mesh_requirement.hpp"
#include "meshes/mesh_writer.hpp"
#include "points/method.hpp"
#include "render/camera.hpp"
#include "render/scene.hpp"
#include "simulate/water.hpp"
#include "simulate/water_fields.hpp"
#include "volumes/particle_writer.hpp"
#include "volumes/volume_reader.hpp"
#include "volumes/volume_writer.hpp"

namespace isoextract::cli {

// Which side of an iso value is inside.
enum class InsideChoice { above, below, away_from_zero };
constexpr auto words_of(InsideChoice /*type*/) {
  return std::array{Word{InsideChoice::above, "above"}, Word{InsideChoice::below, "below"},
                    Word{InsideChoice::away_from_zero, "away-from-zero"}};
}

// What was given on the command line: each value checked by itself, no default applied yet.
struct InputFlags {
  std::vector<std::string> inputs;
  std::vector<std::string> grids;
  std::optional<VolumeChoice> volume;
  std::optional<volumes::ComponentChoice> component;
  std::optional<std::string> format;
  std::optional<glm::ivec3> dims;
  std::optional<field::SampleType> dtype;
  std::optional<std::endian> endian;
  std::optional<std::uint64_t> skip;
  std::optional<volumes::AxisOrder> axis_order;
  std::optional<double> no_data;
  std::optional<glm::dvec3> spacing;
  std::optional<glm::dvec3> origin;
  std::optional<InsideChoice> inside;
  std::optional<std::uint64_t> memory_limit;
  bool in_process = false;

  // The first of the grids.
  [[nodiscard]] std::optional<std::string> grid() const {
    return grids.empty() ? std::nullopt : std::optional(grids.front());
  }
  [[nodiscard]] std::vector<std::string> more_grids() const {
    return {grids.begin() + (grids.empty() ? 0 : 1), grids.end()};
  }
};

// How particles become a field.
struct ParticleFlags {
  std::optional<points::Method> method;
  std::optional<double> radius;
  std::optional<double> smoothing_length;
  std::optional<double> cell_size;
  std::optional<double> weight;
  std::optional<points::Deposit> deposit;
  std::optional<std::array<std::string, 3>> columns;
};

// What --color-by says.
struct ColourFlag {
  std::optional<convert::AttributeChoice> attribute;  // nothing: the iso values
  convert::Colormap map = convert::Colormap::viridis;
  std::optional<std::array<double, 2>> range;
};

struct RunFlags {
  std::optional<int> threads;
  bool quiet = false;
  bool verbose = false;
};

// What decides about a surface besides the iso value.
struct SurfaceFlags {
  std::optional<extract::Method> method;
  std::optional<field::Box> roi;
  bool roi_snap = false;
  std::vector<convert::ClipPlane> clip;
  std::optional<glm::ivec3> resolution;
  std::optional<glm::dvec3> voxel_size;
  std::optional<field::ResampleKernel> kernel;
  std::vector<convert::FilterStep> filters;
  std::vector<convert::BlurStep> blurs;
  bool cap = false;
  std::optional<extract::NanPolicy> nan;
};

// What changes a surface after it is extracted.
struct EditFlags {
  std::optional<convert::LeastPiece> least;
  bool fill_cavities = false;
  std::optional<std::uint64_t> largest;
  bool split = false;
  std::optional<convert::SmoothChoice> smooth;
};

// Of the input's world: a unit, or the one that the file states.
struct UnitChoice {
  std::optional<convert::LengthUnit> unit;
};

struct PlacementFlags {
  std::optional<convert::Space> space;
  std::optional<convert::UpAxis> up;
  std::optional<double> scale;
  std::optional<UnitChoice> unit;
  std::optional<convert::LengthUnit> to_unit;
  std::optional<convert::UpAxis> up_out;
  std::optional<convert::AnatomicalSpace> to_space;
  bool center = false;

  [[nodiscard]] bool any() const { return space || up || scale || unit || to_unit || up_out || to_space || center; }
};

struct DeviceFlags {
  std::optional<gl::DeviceChoice> device;
  std::optional<std::uint64_t> gpu_memory;
};

// How a batch tells how far it is, on stderr.
enum class ProgressStyle {
  bar,   // where that is a terminal
  json,  // a line of JSON an event
  none,
};
constexpr auto words_of(ProgressStyle /*type*/) {
  return std::array{Word{ProgressStyle::bar, "bar"}, Word{ProgressStyle::json, "json"},
                    Word{ProgressStyle::none, "none"}};
}

// What is about many frames.
enum class MissingPolicy {
  error,  // the frames that are there are converted, and the run fails
  note,
};
constexpr auto words_of(MissingPolicy /*type*/) {
  return std::array{Word{MissingPolicy::error, "error"}, Word{MissingPolicy::note, "note"}};
}

struct BatchFlags {
  std::optional<batch::FrameRange> frames;
  std::optional<MissingPolicy> missing;
  std::optional<std::string> iso_table;
  bool animate = false;
  std::optional<double> fps;
  std::optional<int> jobs;
  std::optional<batch::ShardChoice> shard;
  bool resume = false;
  bool fail_fast = false;
  bool no_clobber = false;
  bool make_folders = false;
  bool dry_run = false;
  std::optional<std::string> table;
  std::optional<std::string> plot;
  std::optional<ProgressStyle> progress;
};

// What -o is written as: a format of meshes or, without one, a picture of them or the field itself as an OpenVDB file.
struct OutputFormat {
  std::optional<meshes::MeshFormat> mesh;
  bool picture = false;
};

struct ConvertFlags {
  InputFlags input;
  ParticleFlags particles;
  BatchFlags batch;
  std::optional<convert::Backend> backend;
  DeviceFlags device;
  std::vector<convert::IsoChoice> isos;
  std::optional<std::vector<convert::IsoChoice>> labels;
  SurfaceFlags surface;
  bool no_merge = false;
  bool t_junctions = false;
  std::optional<std::uint64_t> relaxations;
  std::optional<std::string> label_names;
  std::optional<convert::Normals> normals;
  std::vector<convert::AttributeChoice> attributes;
  std::optional<ColourFlag> colour;
  std::optional<std::vector<double>> opacity;
  EditFlags edits;
  std::optional<convert::SimplifyBound> simplify;
  std::optional<convert::TriangleCount> triangles;
  std::optional<convert::EmptyPolicy> empty;
  PlacementFlags placement;
  std::optional<std::string> output;
  std::optional<OutputFormat> format;
  bool half = false;
  std::optional<render::PictureSize> size;
  std::optional<render::ViewAngles> camera;
  std::optional<glm::dvec3> look_at;
  bool ascii = false;
  // Of --draco: its bits, or nothing in it where the voxel says.
  std::optional<std::optional<std::uint64_t>> draco;
  bool quantize = false;
  bool meshopt = false;
  bool optimize_order = false;
  std::optional<field::Interpolation> error;
  bool verify = false;
  bool explain = false;
  std::optional<std::string> report;
  std::optional<std::string> html;
  std::optional<std::string> contact_sheet;
  std::optional<std::string> config;
  RunFlags run;
};

struct InfoFlags {
  InputFlags input;
  std::optional<batch::FrameRange> frames;
  ParticleFlags particles;
  bool json = false;
  RunFlags run;
};

// How the mesh was converted: of these options it has those that decide about triangles.
struct VerifyFlags : ConvertFlags {
  std::optional<std::string> mesh;
  bool json = false;
};

struct CompareFlags {
  std::vector<std::string> meshes;
  std::optional<convert::UpAxis> up;
  std::optional<double> max_distance;
  std::optional<std::uint64_t> memory_limit;
  bool json = false;
  RunFlags run;
};

struct CheckFlags {
  std::vector<std::string> meshes;
  bool weld = false;
  std::optional<std::vector<measure::Requirement>> required;
  std::optional<std::uint64_t> memory_limit;
  bool json = false;
  std::optional<std::string> report;
  RunFlags run;
};

struct RenderFlags {
  InputFlags input;  // volumes and meshes
  ParticleFlags particles;
  std::optional<std::string> frames;
  std::vector<convert::IsoChoice> isos;
  SurfaceFlags surface;
  std::optional<ColourFlag> colour;
  std::optional<std::vector<double>> opacity;
  std::optional<render::Shading> shading;
  std::optional<std::string> transfer;
  std::optional<std::array<double, 2>> transfer_range;
  std::optional<double> unit_length;
  std::optional<render::ViewAngles> camera;
  std::optional<glm::dvec3> look_at;
  std::optional<double> field_of_view;
  std::optional<convert::UpAxis> up;
  std::optional<render::PictureSize> size;
  std::optional<glm::dvec4> background;
  std::optional<std::vector<glm::dvec3>> mesh_colours;
  std::optional<double> samples;
  std::optional<double> termination;
  bool no_skipping = false;
  std::optional<std::string> output;
  std::optional<std::string> json;
  std::optional<convert::Backend> backend;
  DeviceFlags device;
  RunFlags run;
};

struct BenchFlags {
  InputFlags input;
  std::optional<std::vector<int>> sizes;
  std::optional<std::vector<int>> coarser;
  std::optional<double> iso;
  std::optional<std::vector<extract::Method>> methods;
  std::optional<extract::NanPolicy> nan;
  std::optional<std::vector<NamedBackend>> backends;
  DeviceFlags device;
  std::optional<std::vector<int>> threads;
  std::optional<int> repeats;
  std::optional<std::string> csv;
  std::optional<std::string> json;
  std::optional<std::string> plot;
  RunFlags run;
};

struct MergeFlags {
  std::optional<std::string> folder;
  bool quiet = false;
};

struct DevicesFlags {
  bool json = false;
  bool quiet = false;  // says nothing but its results anyway
};

struct StabilityFlags {
  std::vector<std::string> cases;  // all if empty
  std::optional<std::vector<NamedBackend>> backends;
  DeviceFlags device;
  bool list = false;
  bool json = false;
  RunFlags run;
};

// Where the files of a simulation go.
struct SequenceFlags {
  std::optional<std::uint64_t> steps;
  std::optional<std::uint64_t> every;
  std::optional<std::string> output;
  bool no_clobber = false;
  bool make_folders = false;
  std::optional<std::uint64_t> memory_limit;
};

struct WaterFlags {
  std::optional<glm::ivec2> size;
  std::optional<std::uint64_t> seed;
  std::optional<double> relief;
  std::optional<double> level;
  std::optional<double> depth;
  std::vector<simulate::Tap> sources;
  std::vector<simulate::Tap> drains;
  std::optional<simulate::WaterRule> rule;
  std::optional<double> friction;
  std::optional<double> flow_div;
  std::optional<simulate::WaterContent> what;
  std::optional<volumes::VolumeFileFormat> format;
  std::optional<glm::dvec3> spacing;
  SequenceFlags sequence;
  RunFlags run;
};

struct JetFlags {
  std::optional<std::uint64_t> count;
  std::optional<double> radius;
  std::optional<glm::dvec3> tank;
  std::optional<double> nozzle;
  std::optional<double> speed;
  std::optional<std::uint64_t> seed;
  std::optional<std::uint64_t> frames;
  std::optional<double> fps;
  std::optional<double> gravity;
  std::optional<double> viscosity;
  std::optional<std::uint64_t> iterations;
  std::optional<volumes::ParticleFileFormat> format;
  SequenceFlags sequence;
  RunFlags run;
};

struct CommandLine {
  CLI::App app;
  CLI::App* convert = nullptr;
  CLI::App* info = nullptr;
  CLI::App* verify = nullptr;
  CLI::App* compare = nullptr;
  CLI::App* check = nullptr;
  CLI::App* render = nullptr;
  CLI::App* bench = nullptr;
  CLI::App* stability = nullptr;
  CLI::App* devices = nullptr;
  CLI::App* merge = nullptr;
  CLI::App* simulate = nullptr;  // its sub-commands say what
  CLI::App* simulate_water = nullptr;
  CLI::App* simulate_jet = nullptr;
  CLI::App* help = nullptr;
  CLI::App* generate = nullptr;

  ConvertFlags convert_flags;
  InfoFlags info_flags;
  VerifyFlags verify_flags;
  CompareFlags compare_flags;
  CheckFlags check_flags;
  RenderFlags render_flags;
  BenchFlags bench_flags;
  StabilityFlags stability_flags;
  DevicesFlags devices_flags;
  MergeFlags merge_flags;
  WaterFlags water_flags;
  JetFlags jet_flags;
  std::optional<std::string> help_topic;
  std::optional<Document> document;
  bool quiet = false;  // of help and generate, which say nothing else anyway
};

[[nodiscard]] std::unique_ptr<CommandLine> declare_command_line();

// Thrown through CLI11, and caught where the parser is called: a value that its option does not take.
struct BadValue : CLI::ParseError {
  explicit BadValue(isoextract::Error why)
      : CLI::ParseError(why.message, CLI::ExitCodes::ValidationError), error(std::move(why)) {}
  isoextract::Error error;
};

// What the documents ask of the declarations.
[[nodiscard]] std::string synopsis(const CLI::App& command);                // "isoextract info INPUT... [options]"
[[nodiscard]] std::string spelling(const CLI::Option& option);              // "-o, --output FILE"
[[nodiscard]] std::vector<std::string> choices(const CLI::Option& option);  // empty if it takes any value
[[nodiscard]] bool takes_value(const CLI::Option& option);
[[nodiscard]] bool value_is_optional(const CLI::Option& option);  // without one the first choice is meant
[[nodiscard]] std::vector<const CLI::Option*> options_in_group(const CLI::App& command, const std::string& group);
// The commands of the program, or the sub-commands of a command: "water" of "simulate".
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& app);
// The commands of the program, each followed by its sub-commands.
[[nodiscard]] std::vector<const CLI::App*> all_commands(const CLI::App& app);
// As it is written after the program's name: "simulate water".
[[nodiscard]] std::string full_name(const CLI::App& command);

}  // namespace isoextract::cli
