// What all formats of volumes have in common, and the list of them. A new format is a class of its own and a line in
// the list (volume_format.cpp): detection, the help, the man page and the choice of a format follow from what it says
// here.
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
#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"
#include "files/file_start.hpp"

namespace isoextract::volume_io {

// What a headerless file cannot say of itself.
struct RawLayout {
  glm::ivec3 dims{0};  // x (fastest), y, z
  field::SampleType type = field::SampleType::u8;
  std::endian endian = std::endian::little;
  std::uint64_t skip = 0;  // bytes before the first sample

  friend bool operator==(const RawLayout&, const RawLayout&) = default;
};

// Of several numbers a sample: one, counted from 0, or the length of the vector that all of them make.
struct ComponentChoice {
  std::optional<std::int64_t> number;  // nothing: the length

  friend bool operator==(const ComponentChoice&, const ComponentChoice&) = default;
};

// What the axes of an array are, from the one whose index is written first, as NumPy's a[z, y, x]. Without an order of
// its own, the last of them is the fastest in a file.
enum class AxisOrder { zyx, xyz };
constexpr auto words_of(AxisOrder /*type*/) {
  return std::array{Word{AxisOrder::zyx, "zyx"}, Word{AxisOrder::xyz, "xyz"}};
}

// The volume that another one is read beside. A file that states no spacing and no origin lies on its grid where it has
// its dims, or where `spacing` says.
struct VolumeBeside {
  std::string source;  // what messages call it
  glm::ivec3 dims{0};  // 0 where it is sparse
  field::Affine index_to_world;
  std::optional<glm::dvec3> spacing;  // of the file that states none; its origin is then 0,0,0, or `origin`
  std::optional<glm::dvec3> origin;

  friend bool operator==(const VolumeBeside&, const VolumeBeside&) = default;
};

// What is to be read, as plain values.
struct ReadOptions {
  std::optional<std::string> format;         // the id of one; default: by content, then by extension
  std::optional<std::string> grid;           // a grid's label or name (GridInfo), where formats have grids
  std::optional<std::int64_t> volume;        // of a file with several, such as time steps; counted from 0
  std::optional<ComponentChoice> component;  // of a file with several numbers a sample
  std::optional<RawLayout> raw;              // raw files need it; for others it is an error
  std::optional<AxisOrder> axis_order;       // of arrays; zyx where nothing is said
  std::optional<glm::dvec3> spacing;         // replaces what the file says; raw and NPY have 1
  std::optional<glm::dvec3> origin;          // world position of index (0, 0, 0); likewise
  std::optional<VolumeBeside> beside;        // replaces spacing and origin where the file states none
  std::optional<field::FieldKind> kind;      // replaces what the file says
  std::optional<double> no_data;             // dense samples of this value are not a number (field/no_data.hpp)
  bool no_data_if_dense = false;             // sparse samples are left as they are, where no_data is an error for them

  friend bool operator==(const ReadOptions&, const ReadOptions&) = default;
};

// One grid of a file as its header tells, without reading samples.
struct GridInfo {
  std::string name;     // as the file has it, which may be any bytes
  std::string label;    // printable, and of no other grid of the file: NAME, or NAME[k] where it repeats
  std::string type;     // "float", "vec3s", ...
  bool scalar = false;  // a surface can be extracted from it
  std::optional<field::FieldKind> kind;  // where the file says so
  field::IndexBox box;                   // active voxels, or all samples; empty as well if they were not counted
  std::optional<std::uint64_t> voxels;   // active voxels, or all samples; none if they were not counted
  std::uint64_t volumes = 1;             // of this box each: time steps, for example; ReadOptions::volume chooses one
  std::uint64_t components = 1;          // numbers a sample; ReadOptions::component chooses one, or their length
  std::string creator;                   // what the file says made it; may be empty
  std::optional<AttributeKind> kind_of_vectors;  // of a grid of vectors, where the file says so
  bool vectors_in_voxels = false;                // likewise: along the axes of the voxels, in voxels
  std::string frame_problem;                     // why the place that the file gives it cannot be used; empty if it can
  // Of a grid that a plug-in reads in place of its format:
  std::string plugin;              // the plug-in's id; empty if there is none
  bool plugin_is_missing = false;  // it is in none of the folders
  std::vector<std::string> parts;  // of vectors: the labels of the scalar grids that are made of them

  [[nodiscard]] bool is_called(std::string_view wanted) const { return label == wanted || name == wanted; }

  // Whether read_volume reads it, or one of its parts, as far as its header tells.
  [[nodiscard]] bool is_readable() const {
    if (!plugin.empty()) return !plugin_is_missing;
    return scalar && frame_problem.empty();
  }
};

// What a format says of itself without looking at a file.
struct FormatDescription {
  std::string id = {};                       // what it is chosen by: "nrrd"; lower case, and it never changes
  std::string title = {};                    // one line for people: "NRRD, attached or detached, raw or gzip"
  std::vector<std::string> extensions = {};  // the ends of files' names, in lower case: ".nii.gz"
  std::string prefix = {};      // "demo:": inputs that start so are of this format and no files; else empty
  bool has_grids = false;       // a file names its grids, and ReadOptions::grid chooses one
  bool has_volumes = false;     // a file may hold several volumes, and ReadOptions::volume chooses one
  bool has_components = false;  // a sample may be several numbers, and ReadOptions::component chooses
  bool has_axis_order = false;  // its axes have no order of their own, and ReadOptions::axis_order may say another
  bool needs_layout = false;    // files do not say what is in them: ReadOptions::raw has to
};

// Formats live as long as the program, keep nothing of a file between calls and may be used by several threads at once.
// Where `input` is named, it is the path of a file, or a text that starts with the format's prefix. Options were
// checked against the description. What they throw, std::bad_alloc for example, is caught by whoever calls them by way
// of volume_reader.hpp. Failures are ErrorCode::input unless said otherwise, and messages name the file.
class VolumeFormat {
 public:
  explicit VolumeFormat(FormatDescription about) : about_(std::move(about)) {}
  virtual ~VolumeFormat() = default;
  VolumeFormat(const VolumeFormat&) = delete;
  VolumeFormat& operator=(const VolumeFormat&) = delete;

  [[nodiscard]] const FormatDescription& about() const { return about_; }

  // Whether a file that starts so is of this format, beyond doubt. False where only its name can tell.
  [[nodiscard]] virtual bool probe(const files::FileStart& /*start*/) const { return false; }

  // The grids there are, scalar or not; one where the format has no names for them. Never reads samples.
  [[nodiscard]] virtual Result<std::vector<GridInfo>> list(const std::string& input, const ReadOptions& options,
                                                           const Context& context) const = 0;

  // The files that open() would look at. One may be named twice. Never reads samples.
  [[nodiscard]] virtual Result<std::vector<std::filesystem::path>> files(const std::string& input,
                                                                         const ReadOptions& options,
                                                                         const Context& context) const = 0;

  // One grid, dense or sparse as the file has it, with its place (options applied), its notes and `grids`. Its samples
  // stay reserved in the context's memory for as long as they live, unless they are a mapping of their file.
  [[nodiscard]] virtual Result<field::ScalarField> open(const std::string& input, const ReadOptions& options,
                                                        const Context& context) const = 0;

 private:
  FormatDescription about_;
};

// All of them, in the order in which they are asked and shown.
[[nodiscard]] std::span<const VolumeFormat* const> volume_formats();
// Null where there is none of that id.
[[nodiscard]] const VolumeFormat* find_volume_format(std::string_view id);

}  // namespace isoextract::volume_io
