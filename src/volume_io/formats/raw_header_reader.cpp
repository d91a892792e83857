// Text headers beside a raw file: the .dat files of the volvis collection (also of Voreen, ImageVis3D and Inviwo) and
// the .ini files of UnityVolumeRendering. A line has a key, a colon and a value; case does not matter.
//
//   ObjectFileName: engine.raw     or Rawfile; without one: the header's name without .ini or .dat, and with .raw
//   Resolution: 256 256 128        or dimx, dimy and dimz; x varies fastest
//   Format: USHORT                 or UINT16, Vec2FLOAT32, ...
//   ObjectModel: RGBA              number of components: I (1), RGB and XYZ (3), RGBA (4)
//   SliceThickness: 1 1 2          or Spacing: distances between samples
//   BasisVector1: 5.684 0 0        the first edge of the box of all voxels; also 2 and 3
//   Offset: 0 0 0                  the corner of that box
//   ByteOffset: 512                or skip: bytes before the first sample
//   Endianess: BIG                 or ByteOrder
#include <algorithm>
#include <charconv>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "files/text_file.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/formats/raw_file.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::uint64_t kMaxHeaderBytes = std::uint64_t{64} << 10;  // largest header
constexpr std::size_t kHeaderShown = 60;                            // most bytes of a value shown in a message

using Keys = std::map<std::string, std::string, std::less<>>;  // values by keys in lower case

// Returns the lines "KEY: VALUE" or "KEY=VALUE" of a text; the first of each key counts.
Keys keys_of(std::string_view text) {
  Keys keys;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t at = line.find_first_of(":=");
    if (at == std::string_view::npos) continue;
    keys.emplace(to_lower(trimmed(line.substr(0, at))), std::string(trimmed(line.substr(at + 1))));
  }
  return keys;
}

// A header with its file's name for messages.
struct Header {
  std::string file;
  Keys keys;

  // Returns the value of the first of these keys that the header has; null without one.
  [[nodiscard]] const std::string* find(std::initializer_list<std::string_view> names) const {
    for (const std::string_view name : names) {
      if (const auto found = keys.find(name); found != keys.end()) return &found->second;
    }
    return nullptr;
  }

  [[nodiscard]] Error bad(std::string_view key, std::string_view expected, std::string_view value) const {
    return {ErrorCode::input,
            fmt::format("{}: expected {} as '{}', found '{}'", file, expected, key, printable(value, kHeaderShown)),
            {}};
  }
};

// Returns the `count` numbers of the text; nothing if it has other content.
template <class T>
std::optional<std::array<T, 3>> numbers_of(std::string_view text, std::size_t count) {
  std::array<T, 3> numbers{};
  for (std::size_t i = 0; i < count; ++i) {
    text = trimmed(text);
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), numbers[i]);
    if (status != std::errc{}) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return trimmed(text).empty() ? std::optional(numbers) : std::nullopt;
}

Result<glm::ivec3> dims_of(const Header& header) {
  const std::string* resolution = header.find({"resolution"});
  std::string text = resolution != nullptr ? *resolution : "";
  for (const char* key : {"dimx", "dimy", "dimz"}) {
    const std::string* size = header.find({key});
    if (resolution == nullptr && size != nullptr) text += *size + " ";
  }
  const auto dims = numbers_of<int>(text, 3);
  if (dims && (*dims)[0] > 0 && (*dims)[1] > 0 && (*dims)[2] > 0) return glm::ivec3((*dims)[0], (*dims)[1], (*dims)[2]);
  return tl::unexpected(header.bad("Resolution", "three numbers from 1 on", text));
}

// Sets the sample type and, from "Vec3FLOAT32" or the object model, the components.
Result<void> set_type(const Header& header, RawLayout& layout) {
  using field::SampleType;
  static const std::map<std::string, SampleType, std::less<>> types{
      {"uchar", SampleType::u8},   {"byte", SampleType::u8},     {"uint8", SampleType::u8},
      {"char", SampleType::i8},    {"int8", SampleType::i8},     {"ushort", SampleType::u16},
      {"uint16", SampleType::u16}, {"short", SampleType::i16},   {"int16", SampleType::i16},
      {"uint", SampleType::u32},   {"uint32", SampleType::u32},  {"int", SampleType::i32},
      {"int32", SampleType::i32},  {"half", SampleType::f16},    {"float16", SampleType::f16},
      {"float", SampleType::f32},  {"float32", SampleType::f32}, {"double", SampleType::f64},
      {"float64", SampleType::f64}};
  const std::string* format = header.find({"format"});
  std::string word = format != nullptr ? to_lower(*format) : "";
  if (word.size() > 4 && word.starts_with("vec") && word[3] >= '1' && word[3] <= '4') {
    layout.components = static_cast<std::uint64_t>(word[3] - '0');
    word.erase(0, 4);
  }
  const auto type = types.find(word);
  if (type == types.end()) {
    return tl::unexpected(
        header.bad("Format", "a sample type such as UCHAR, USHORT or FLOAT32", format != nullptr ? *format : ""));
  }
  layout.type = type->second;
  const std::string* model = header.find({"objectmodel"});
  const std::string of_model = model != nullptr ? to_lower(*model) : "";
  if (of_model == "rgb" || of_model == "xyz") layout.components = 3;
  if (of_model == "rgba") layout.components = 4;
  return {};
}

Result<void> set_bytes(const Header& header, RawLayout& layout) {
  if (const std::string* order = header.find({"endianess", "endianness", "byteorder"})) {
    const std::string word = to_lower(*order);
    if (!word.starts_with("big") && !word.starts_with("little")) {
      return tl::unexpected(header.bad("ByteOrder", "big or little", *order));
    }
    layout.endian = word.starts_with("big") ? std::endian::big : std::endian::little;
  }
  if (const std::string* skip = header.find({"byteoffset", "skip"})) {
    const auto number = numbers_of<std::uint64_t>(*skip, 1);
    if (!number) return tl::unexpected(header.bad("ByteOffset", "a number of bytes", *skip));
    layout.skip = (*number)[0];
  }
  return {};
}

Result<std::optional<glm::dvec3>> vector_of(const Header& header, std::initializer_list<std::string_view> names) {
  const std::string* text = header.find(names);
  if (text == nullptr) return std::optional<glm::dvec3>();
  const auto numbers = numbers_of<double>(*text, 3);
  if (!numbers) return tl::unexpected(header.bad(*names.begin(), "three numbers", *text));
  return std::optional(glm::dvec3((*numbers)[0], (*numbers)[1], (*numbers)[2]));
}

Result<Frame> frame_of(const Header& header, const glm::ivec3& dims) {
  Frame frame;
  glm::dmat3& axes = frame.index_to_world.linear;
  const auto spacing = TRY(vector_of(header, {"slicethickness", "spacing"}));
  frame.stated = spacing.has_value();
  for (int i = 0; i < 3; ++i) {
    const auto edge = TRY(vector_of(header, {fmt::format("basisvector{}", i + 1)}));
    if (edge) {
      axes[i] = *edge / static_cast<double>(dims[i]);
      frame.stated = true;
    } else if (spacing) {
      axes[i][i] = (*spacing)[i];
    }
  }
  const auto corner = TRY(vector_of(header, {"offset"}));
  if (corner) {
    frame.index_to_world.offset = *corner + axes * glm::dvec3(0.5);
  } else if (frame.stated) {
    frame.assumed_origin.push_back({NoteId::placement_assumed, "the header has no offset: the reader assumes 0,0,0"});
  }
  return frame;
}

// Returns the raw file: as named in the header, else beside it with the same name.
Result<std::filesystem::path> data_file_of(const Header& header, const std::filesystem::path& path) {
  if (const std::string* name = header.find({"objectfilename", "rawfile"})) return files::resolve_beside(path, *name);
  const std::filesystem::path stem = path.filename().stem();
  return files::resolve_beside(path, stem.has_extension() ? stem.string() : stem.string() + ".raw");
}

Result<DenseFile> open_header_file(const files::InputFile& file) {
  const std::string text =
      TRY(files::read_text_file(file.path(), "the header of a raw file", kMaxHeaderBytes, file.context()));
  const Header header{file.name(), keys_of(text)};
  if (const std::string* grid = header.find({"gridtype"}); grid != nullptr && to_lower(*grid) != "equidistant") {
    return tl::unexpected(header.bad("GridType", "EQUIDISTANT", *grid));
  }
  RawLayout layout;
  layout.dims = TRY(dims_of(header));
  TRY(set_type(header, layout));
  TRY(set_bytes(header, layout));
  const std::filesystem::path path = TRY(data_file_of(header, file.path()));
  const auto data = TRY(files::InputFile::open(path, file.context()));
  auto dense = open_raw(data, layout, AxisOrder::zyx);
  if (!dense) return fail(dense.error().code, dense.error().message, "check the sizes and the format in the header");
  dense->format = "raw with a header";
  dense->frame = TRY(frame_of(header, layout.dims));
  if (const std::string* unit = header.find({"axesunits"})) {
    dense->length_unit = std::string(trimmed(std::string_view(*unit).substr(0, unit->find_first_of(" \t"))));
  }
  return dense;
}

class RawHeaderFormat final : public DenseFormat {
 public:
  RawHeaderFormat()
      : DenseFormat({.id = "dat",
                     .title = "header of a raw file: volvis, Voreen, Inviwo",
                     .extensions = {".dat", ".raw.ini"},
                     .has_volumes = true,
                     .has_components = true}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    if (start.packed) return false;
    const Keys keys = keys_of({reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size()});
    const bool is_volvis = keys.contains("resolution") && (keys.contains("objectfilename") || keys.contains("rawfile"));
    return is_volvis || (keys.contains("dimx") && keys.contains("dimy") && keys.contains("dimz"));
  }

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file,
                                              const ReadOptions& /*options*/) const override {
    return open_header_file(file);
  }
};

}  // namespace

const VolumeFormat& raw_header_format() {
  static const RawHeaderFormat format;
  return format;
}

}  // namespace isoextract::volume_io
