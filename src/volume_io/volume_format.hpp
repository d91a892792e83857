// The interface of volume formats, and their list. A new format is a class and a line in the list (volume_format.cpp).
// Help and man page use its FormatDescription; so does the choice of a format by name or extension. The choice by
// content uses probe().
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/attribute_kind.hpp"
#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "files/file_part.hpp"
#include "files/file_start.hpp"

namespace isoextract::volume_io {

// Layout of a headerless file.
struct RawLayout {
  glm::ivec3 dims{0};  // x, y, z; x varies fastest unless ReadOptions::axis_order is xyz
  field::SampleType type = field::SampleType::u8;
  std::endian endian = std::endian::little;
  std::uint64_t skip = 0;        // bytes before the first sample
  std::uint64_t components = 1;  // numbers per sample
  bool planar = false;           // a volume has all samples of component 0, then all of component 1, and so on;
                                 // otherwise the components of each sample lie together

  friend bool operator==(const RawLayout&, const RawLayout&) = default;
};

// Selects one of several components per sample by its index from 0, or the length of the vector of all components.
struct ComponentChoice {
  std::optional<std::int64_t> number;  // empty: the vector's length

  friend bool operator==(const ComponentChoice&, const ComponentChoice&) = default;
};

// Meaning of an array's axes, starting with the first index as in NumPy's a[z, y, x]. Unless the file specifies the
// storage order, the last axis is the fastest.
enum class AxisOrder { zyx, xyz };
constexpr auto words_of(AxisOrder /*type*/) {
  return std::array{Word{AxisOrder::zyx, "zyx"}, Word{AxisOrder::xyz, "xyz"}};
}

// Places a file that states no placement, such as the file of --attribute NAME=FILE. If `spacing` is set, the file gets
// this spacing, and its first sample lies at `origin`, by default (0, 0, 0). Otherwise the file must have `dims`
// samples and gets `index_to_world`, in which `origin` replaces the offset if it is set.
struct ReferenceVolume {
  std::string source;  // name for messages
  glm::ivec3 dims{0};  // 0 if sparse
  field::Affine index_to_world;
  std::optional<glm::dvec3> spacing;
  std::optional<glm::dvec3> origin;

  friend bool operator==(const ReferenceVolume&, const ReferenceVolume&) = default;
};

// Selects the contents to read, and replaces properties that the file states.
struct ReadOptions {
  std::optional<std::string> format;         // id of a format; default: by content, then by extension
  std::optional<std::string> grid;           // a grid's label or name (GridInfo), for formats with grids
  std::optional<std::int64_t> volume;        // for files with several volumes, such as time steps; from 0
  std::optional<ComponentChoice> component;  // for files with several components per sample
  std::optional<RawLayout> raw;              // required for raw files, an error for others
  std::optional<AxisOrder> axis_order;       // of arrays; default zyx
  std::optional<glm::dvec3> spacing;         // replaces the file's spacing, which is 1 for raw and NPY files
  std::optional<glm::dvec3> origin;          // replaces the file's origin: world position of index (0, 0, 0)
  std::optional<ReferenceVolume> beside;     // provides the placement if the file states none
  std::optional<field::FieldKind> kind;      // replaces the file's kind
  std::optional<double> no_data;             // dense samples of this value become NaN (field/no_data.hpp)
  bool no_data_for_dense_only = false;       // ignore no_data for sparse samples, for which it is otherwise an error
  std::optional<std::uint64_t> level;        // of a pyramid of resolutions; default 0, the finest
  std::optional<glm::dvec3> sampling;        // spacing at which the reader samples data without a lattice
  bool resamples = false;                    // resample unevenly spaced samples, otherwise an error
  bool flat = false;                         // accept arrays [y, x], as volumes of one slice
  bool label_ids = false;                    // 64-bit integers are ids of labels: kept exactly (ScalarField::label_ids)
  bool by_layers = false;  // the caller takes DenseSamples::layers, if the address space is too small for the file
  std::optional<field::Box> region;  // samples beyond it need not be read; in world coordinates

  friend bool operator==(const ReadOptions&, const ReadOptions&) = default;
};

// One grid of a file as described by its header, without reading samples.
struct GridInfo {
  std::string name;                      // as in the file; may be any bytes
  std::string label;                     // printable and unique in the file: NAME, or NAME[k] if it repeats
  std::string type;                      // "float", "vec3s", ...
  bool scalar = false;                   // whether a surface can be extracted
  std::optional<field::FieldKind> kind;  // if the file specifies it
  field::IndexBox box;                   // of the active voxels, or all samples if dense; empty if the header has none
  std::optional<std::uint64_t> voxels;   // active voxels, or all samples; absent if the header has no count
  std::uint64_t volumes = 1;             // volumes with this box, such as time steps; ReadOptions::volume selects one
  std::uint64_t components = 1;          // components per sample; ReadOptions::component selects one, or their length
  std::string creator;                   // program that wrote it; may be empty
  std::optional<AttributeKind> kind_of_vectors;  // of a vector grid, if the file specifies it
  bool vectors_in_voxels = false;                // of a vector grid: vectors are in index space, in voxels
  std::vector<field::LabelName> labels;          // as in ScalarField
  std::vector<double> volume_times;              // of each volume; empty if the file states none
  std::string time_unit;                         // as in ScalarField, also length_unit and world_space
  std::string length_unit;
  std::string world_space;
  std::string component_names;    // in order, separated by spaces; may be empty
  std::string placement_problem;  // why the file's transform cannot be used; empty if it can
  // For grids that a plug-in reads instead of the format itself:
  std::string plugin;              // the plug-in's id; may be empty
  bool plugin_is_missing = false;  // in no folder of plugin_host::plugin_folders()
  std::vector<std::string> parts;  // of a vector grid: labels of the scalar grids it provides

  // A name may be written as a path: "/density".
  [[nodiscard]] bool matches_name(std::string_view wanted) const {
    if (label == wanted || name == wanted) return true;
    return wanted.starts_with('/') && name == wanted.substr(1);
  }

  // Returns whether read_volume() can read the grid or one of its parts, judging by its header.
  [[nodiscard]] bool is_readable() const {
    if (!plugin.empty()) return !plugin_is_missing;
    return scalar && placement_problem.empty();
  }
};

// Properties of a format.
struct FormatDescription {
  std::string id = {};                       // name by which it is selected: "nrrd"; lower case, never changes
  std::string title = {};                    // one line for users: "NRRD, attached or detached, raw or gzip"
  std::vector<std::string> extensions = {};  // file name endings in lower case: ".nii.gz"
  std::string prefix = {};      // "demo:": inputs with this prefix are of this format and are not files; may be empty
  bool has_grids = false;       // files have named grids, selected by ReadOptions::grid
  bool has_volumes = false;     // files may have several volumes, selected by ReadOptions::volume
  bool has_components = false;  // samples may have several components, selected by ReadOptions::component
  bool has_axis_order = false;  // files do not specify the order of axes; ReadOptions::axis_order may
  bool needs_layout = false;    // files have no header; needs ReadOptions::raw
  bool has_levels = false;      // files may have several resolutions, selected by ReadOptions::level
  bool takes_slices = false;    // single pictures: a pattern or folder of them is one volume (detail/slice_stack.hpp)
  std::string library = {};     // the reader's library: "GDCM"; empty for the program's own code
  std::string package = {};     // the Debian package that building the plug-in needs
  std::string plugin = {};      // path of the plug-in that reads the format; empty if none is needed or found
  bool is_plugin = false;
};

// A format lives as long as the program, keeps no state of a file between calls, and is safe to use from several
// threads. `input` is the path of a file or folder, a pattern of slices (FormatDescription::takes_slices), or a text
// with the format's prefix. Options have been checked against the description; formats ignore `sampling` and
// `resamples` if their samples lie on a lattice. volume_reader.hpp catches exceptions such as std::bad_alloc. Failures
// are ErrorCode::input unless stated otherwise; messages name the file.
class VolumeFormat {
 public:
  explicit VolumeFormat(FormatDescription about) : about_(std::move(about)) {}
  virtual ~VolumeFormat() = default;
  VolumeFormat(const VolumeFormat&) = delete;
  VolumeFormat& operator=(const VolumeFormat&) = delete;

  [[nodiscard]] const FormatDescription& about() const { return about_; }

  // Returns whether the start of a file proves that it is of this format; false if only its name can tell.
  [[nodiscard]] virtual bool probe(const files::FileStart& /*start*/) const { return false; }

  // Returns whether a folder is an input of this format.
  [[nodiscard]] virtual bool probe_folder(const std::filesystem::path& /*folder*/, const Context& /*context*/) const {
    return false;
  }

  // Lists the grids, scalar or not; a single one if the format does not name them. Only plug-ins may read samples for
  // it.
  [[nodiscard]] virtual Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                           const Context& context) const = 0;

  // Lists the files that open() would read; a file may be listed twice. Only plug-ins may read samples for it.
  [[nodiscard]] virtual Result<std::vector<std::filesystem::path>> files(const std::string& input,
                                                                         const ReadOptions& options,
                                                                         const Context& context) const = 0;

  // Returns the bytes that the selected volume depends on, as parts of the files in files(). A part without ranges is
  // its whole file.
  [[nodiscard]] virtual Result<std::vector<files::FilePart>> parts(const std::string& input, const ReadOptions& options,
                                                                   const Context& context) const;

  // Reads one grid, dense or sparse as in the file. Sets its transform (with the spacing and origin of the options),
  // its notes and ScalarField::grids; read_volume() applies ReadOptions::kind and no_data. The memory of samples that
  // are not mapped from their file stays reserved in the context for as long as they live.
  [[nodiscard]] virtual Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                        const Context& context) const = 0;

 private:
  FormatDescription about_;
};

// Returns all formats in the order of detection and display.
[[nodiscard]] std::span<const VolumeFormat* const> volume_formats();
// Returns the format with this id; null if there is none.
[[nodiscard]] const VolumeFormat* find_volume_format(std::string_view id);

}  // namespace isoextract::volume_io
