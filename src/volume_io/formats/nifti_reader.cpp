// NIfTI-1 and NIfTI-2. Uses the NIfTI reference library for the header's layout, byte swapping, type names and
// quaternions. Does not use its reader, which sets NaN and infinite samples to 0, replaces invalid spacings by 1 and
// prints errors on stderr.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>
#include <nifti2_io.h>

#include "base/ascii.hpp"
#include "base/checked.hpp"
#include "files/file_start.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/formats.hpp"

namespace isoextract::volume_io {
namespace {

// The members that are used, from either version of the header.
struct NiftiHeader {
  int version = 1;
  bool swapped = false;
  bool pair = false;  // the samples are in a separate file
  std::array<std::int64_t, 8> dim{};
  int datatype = 0;
  std::array<double, 8> pixdim{};
  double vox_offset = 0;
  double slope = 0;
  double intercept = 0;
  int qform_code = 0;
  int sform_code = 0;
  std::array<double, 3> quaternion{};
  std::array<double, 3> offset{};
  std::array<std::array<double, 4>, 3> rows{};
  int units = 0;
};

template <class Raw>
NiftiHeader convert(const Raw& raw) {
  NiftiHeader header;
  std::copy_n(raw.dim, 8, header.dim.begin());
  header.datatype = raw.datatype;
  std::copy_n(raw.pixdim, 8, header.pixdim.begin());
  header.vox_offset = static_cast<double>(raw.vox_offset);
  header.slope = raw.scl_slope;
  header.intercept = raw.scl_inter;
  header.qform_code = raw.qform_code;
  header.sform_code = raw.sform_code;
  header.quaternion = {raw.quatern_b, raw.quatern_c, raw.quatern_d};
  header.offset = {raw.qoffset_x, raw.qoffset_y, raw.qoffset_z};
  std::copy_n(raw.srow_x, 4, header.rows[0].begin());
  std::copy_n(raw.srow_y, 4, header.rows[1].begin());
  std::copy_n(raw.srow_z, 4, header.rows[2].begin());
  header.units = XYZT_TO_SPACE(raw.xyzt_units);
  return header;
}

template <class Raw>
std::optional<NiftiHeader> parse_as(std::span<const std::byte> content, int version, std::string_view one_file,
                                    std::string_view two_files) {
  alignas(8) Raw raw;
  if (content.size() < sizeof raw) return std::nullopt;
  std::memcpy(&raw, content.data(), sizeof raw);
  const bool is_native = raw.sizeof_hdr == static_cast<int>(sizeof raw);
  const bool is_swapped = raw.sizeof_hdr == static_cast<int>(__builtin_bswap32(sizeof raw));
  const std::string_view magic(raw.magic, one_file.size());
  if (!(is_native || is_swapped) || (magic != one_file && magic != two_files)) return std::nullopt;
  if (is_swapped) ::swap_nifti_header(&raw, version);
  NiftiHeader header = convert(raw);
  header.version = version;
  header.swapped = is_swapped;
  header.pair = magic == two_files;
  return header;
}

std::optional<NiftiHeader> parse_header(std::span<const std::byte> content) {
  using namespace std::string_view_literals;
  if (auto header = parse_as<nifti_1_header>(content, 1, "n+1\0"sv, "ni1\0"sv)) return header;
  return parse_as<nifti_2_header>(content, 2, "n+2\0\r\n\032\n"sv, "ni2\0\r\n\032\n"sv);
}

struct NiftiType {
  field::SampleType type = field::SampleType::u8;
  std::uint64_t numbers = 1;  // components per sample, interleaved
  Integer64 wide = Integer64::none;
};

std::optional<NiftiType> type_of_code(int datatype) {
  using enum field::SampleType;
  switch (datatype) {
    case NIFTI_TYPE_UINT8: return NiftiType{u8};
    case NIFTI_TYPE_INT8: return NiftiType{i8};
    case NIFTI_TYPE_UINT16: return NiftiType{u16};
    case NIFTI_TYPE_INT16: return NiftiType{i16};
    case NIFTI_TYPE_UINT32: return NiftiType{u32};
    case NIFTI_TYPE_INT32: return NiftiType{i32};
    case NIFTI_TYPE_UINT64: return NiftiType{f64, 1, Integer64::u64};
    case NIFTI_TYPE_INT64: return NiftiType{f64, 1, Integer64::i64};
    case NIFTI_TYPE_FLOAT32: return NiftiType{f32};
    case NIFTI_TYPE_FLOAT64: return NiftiType{f64};
    case NIFTI_TYPE_RGB24: return NiftiType{u8, 3};
    case NIFTI_TYPE_RGBA32: return NiftiType{u8, 4};
    case NIFTI_TYPE_COMPLEX64: return NiftiType{f32, 2};
    case NIFTI_TYPE_COMPLEX128: return NiftiType{f64, 2};
    default: return std::nullopt;
  }
}

Result<glm::ivec3> read_dims(const std::string& file, const NiftiHeader& header, field::SampleType type) {
  const std::int64_t axes = header.dim[0];
  if (axes < 3 || axes > 7) {
    return fail(ErrorCode::input, fmt::format("{}: expected 3 to 7 axes (dim[0]), found {}", file, axes));
  }
  std::array<std::uint64_t, 3> sizes{};
  for (std::size_t axis = 1; axis <= static_cast<std::size_t>(axes); ++axis) {
    const std::int64_t size = header.dim[axis];
    if (size < 1) {
      return fail(ErrorCode::input, fmt::format("{}: expected sizes from 1 on, found dim[{}] = {}", file, axis, size));
    }
    if (axis <= 3) sizes[axis - 1] = static_cast<std::uint64_t>(size);
  }
  return checked_dims(file, sizes, type);
}

// Returns the number of components: axis 4 counts volumes, later axes count components. The sizes are above 0.
std::optional<std::uint64_t> component_count(const NiftiHeader& header) {
  std::optional<std::uint64_t> count = 1;
  for (std::size_t axis = 5; axis <= static_cast<std::size_t>(header.dim[0]) && count; ++axis) {
    count = checked_product(*count, static_cast<std::uint64_t>(header.dim[axis]));
  }
  return count;
}

template <std::size_t N>
bool all_finite(const std::array<double, N>& values, std::size_t first = 0, std::size_t last = N) {
  return std::all_of(values.begin() + static_cast<std::ptrdiff_t>(first),
                     values.begin() + static_cast<std::ptrdiff_t>(last), [](double v) { return std::isfinite(v); });
}

// Returns the placement by the standard's three methods: sform, qform, or spacings alone.
Frame frame_of(const NiftiHeader& header) {
  Frame frame;
  field::Affine& affine = frame.index_to_world;
  if (header.sform_code > 0) {
    for (int row = 0; row < 3; ++row) {
      const auto& entries = header.rows[static_cast<std::size_t>(row)];
      if (!all_finite(entries)) frame.problem = "the sform has entries that are not finite";
      for (int column = 0; column < 3; ++column) {
        affine.linear[column][row] = entries[static_cast<std::size_t>(column)];
      }
      affine.offset[row] = entries[3];
    }
    return frame;
  }
  for (std::size_t axis = 1; axis <= 3; ++axis) {
    if (!(std::isfinite(header.pixdim[axis]) && header.pixdim[axis] > 0)) {
      frame.problem =
          fmt::format("expected a spacing greater than 0, found pixdim[{}] = {}", axis, header.pixdim[axis]);
      return frame;
    }
  }
  if (header.qform_code <= 0) {
    affine = field::scaling({header.pixdim[1], header.pixdim[2], header.pixdim[3]});
    frame.assumed_axes.push_back(
        {NoteId::placement_assumed, "the header has no sform or qform: it states spacings but no orientation"});
    return frame;
  }
  if (!all_finite(header.quaternion) || !all_finite(header.offset)) {
    frame.problem = "the qform has entries that are not finite";
    return frame;
  }
  const nifti_dmat44 matrix = ::nifti_quatern_to_dmat44(
      header.quaternion[0], header.quaternion[1], header.quaternion[2], header.offset[0], header.offset[1],
      header.offset[2], header.pixdim[1], header.pixdim[2], header.pixdim[3], header.pixdim[0] < 0 ? -1.0 : 1.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) affine.linear[column][row] = matrix.m[row][column];
    affine.offset[row] = matrix.m[row][3];
  }
  return frame;
}

// Returns "" for the standard's code 0, "unknown"; shows invalid codes as they are.
std::string length_unit_of(const NiftiHeader& header) {
  switch (header.units) {
    case NIFTI_UNITS_UNKNOWN: return "";
    case NIFTI_UNITS_METER: return "m";
    case NIFTI_UNITS_MM: return "mm";
    case NIFTI_UNITS_MICRON: return "um";
    default: return fmt::format("code {}", header.units);
  }
}

field::ValueScale scale_of(const NiftiHeader& header, Notes& notes) {
  if (header.slope == 0) return {};
  if (!std::isfinite(header.slope)) {
    notes.push_back({NoteId::value_scale, "scl_slope is infinite or NaN: the reader uses the values as stored"});
    return {};
  }
  if (!std::isfinite(header.intercept)) {
    notes.push_back({NoteId::value_scale, "scl_inter is infinite or NaN: the reader uses 0"});
    return {header.slope, 0};
  }
  return {header.slope, header.intercept};
}

bool has_extension(const std::filesystem::path& path, std::string_view extension) {
  const std::string name = path.filename().string();
  return name.size() >= extension.size() &&
         std::equal(extension.begin(), extension.end(), name.end() - static_cast<std::ptrdiff_t>(extension.size()),
                    [](char a, char b) { return a == (b | 0x20) || a == b; });
}

// "a.img.gz" -> "a"; only for names with an extension of a header/image pair.
std::optional<std::filesystem::path> pair_stem(const std::filesystem::path& path) {
  for (const std::string_view extension : {".hdr.gz", ".img.gz", ".hdr", ".img"}) {
    if (!has_extension(path, extension)) continue;
    const std::string name = path.string();
    return name.substr(0, name.size() - extension.size());
  }
  return std::nullopt;
}

// Returns the other file of a header/image pair.
Result<std::filesystem::path> find_partner(const files::InputFile& file, std::string_view extension) {
  if (files::is_standard_input(file.path())) {
    return fail(ErrorCode::input,
                fmt::format("{}: this is one file of a NIfTI pair; the other file needs to be in the same folder, "
                            "which standard input does not have",
                            file.name()),
                "give the path of the file, or join the pair into one .nii file");
  }
  const auto stem = pair_stem(file.path());
  std::string tried;
  for (const std::string_view packed : {"", ".gz"}) {
    if (!stem) break;
    const std::string ending = fmt::format("{}{}", extension, packed);
    for (const std::string& as_written : {ending, to_upper(ending)}) {
      const std::string partner = stem->filename().string() + as_written;
      std::error_code error;
      if (std::filesystem::exists(file.path().parent_path() / partner, error)) {
        return files::resolve_beside(file.path(), partner);
      }
    }
    tried += fmt::format("{}{}{}", tried.empty() ? "" : " or ", stem->filename().string(), ending);
  }
  if (!stem) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: this is one file of a NIfTI pair; expected a file name that ends in .hdr, .img, .hdr.gz "
                    "or .img.gz",
                    file.name()));
  }
  return fail(ErrorCode::input, fmt::format("{}: this is one file of a NIfTI pair, but there is no {} in its folder",
                                            file.name(), tried));
}

// Returns the location of the samples.
Result<SamplePiece> locate_samples(const files::InputFile& file, const NiftiHeader& header) {
  SamplePiece piece{file.path()};
  constexpr double kMaxOffset = 0x1p62;
  const double first = header.pair ? 0 : (header.version == 1 ? 352 : 544);
  if (!(header.vox_offset >= first && header.vox_offset <= kMaxOffset) ||
      header.vox_offset != std::floor(header.vox_offset)) {
    return fail(ErrorCode::input, fmt::format("{}: expected a whole number from {} on, found vox_offset {}",
                                              file.name(), first, header.vox_offset));
  }
  if (header.pair) {
    piece.path = TRY(find_partner(file, ".img"));
  }
  const auto image = TRY(files::InputFile::open(piece.path, file.context()));
  std::array<std::byte, 2> start{};
  if (image.size() >= start.size()) {
    TRY(image.read_at(0, start));
  }
  // The image of a pair has no signature: only its name shows that it is compressed.
  piece.gzip = header.pair ? has_extension(piece.path, ".gz") : files::is_gzip(start);
  (piece.gzip ? piece.skip : piece.offset) = static_cast<std::uint64_t>(header.vox_offset);
  return piece;
}

Result<DenseFile> open_with_header(const files::InputFile& file, const NiftiHeader& header) {
  const auto type = type_of_code(header.datatype);
  if (!type) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected integers, floats, complex numbers or RGB colors with 8 to 64 bits per "
                            "number, found datatype {} ({})",
                            file.name(), header.datatype, ::nifti_datatype_to_string(header.datatype)),
                "convert the samples to FLOAT32 or INT16 first");
  }
  const auto dims = TRY(read_dims(file.name(), header, type->type));
  const auto volumes = static_cast<std::uint64_t>(header.dim[0] >= 4 ? header.dim[4] : 1);
  const auto components = component_count(header);
  if (components != 1 && type->numbers > 1) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: expected a datatype with one number per sample, because dim[5] and later axes already count "
                    "components, found {} ({} numbers per sample)",
                    file.name(), ::nifti_datatype_to_string(header.datatype), type->numbers),
        "convert the samples to a scalar datatype, or keep only dim[1] to dim[4]");
  }
  const std::uint64_t parts =
      components ? checked_product(volumes, *components, type->numbers).value_or(~std::uint64_t{0}) : ~std::uint64_t{0};
  TRY(check_volume_count(file.name(), dims, type->type, parts));
  auto piece = TRY(locate_samples(file, header));

  DenseFile dense;
  dense.format = header.version == 1 ? "NIfTI-1" : "NIfTI-2";
  dense.world_space = "RAS+ (NIfTI)";
  dense.type = type->type;
  dense.wide = type->wide;
  dense.dims = dims;
  dense.volumes = volumes;
  dense.components = *components * type->numbers;
  dense.components_interleaved = type->numbers > 1;
  dense.component_before_volume = false;
  if (header.swapped) {
    dense.endian = std::endian::native == std::endian::little ? std::endian::big : std::endian::little;
  }
  const bool is_color = header.datatype == NIFTI_TYPE_RGB24 || header.datatype == NIFTI_TYPE_RGBA32;
  if (!is_color) dense.scale = scale_of(header, dense.notes);  // the standard does not scale colors
  dense.frame = frame_of(header);
  dense.pieces = {std::move(piece)};
  dense.length_unit = length_unit_of(header);
  return dense;
}

tl::unexpected<Error> fail_no_header(const files::InputFile& file) {
  return files::bad_signature_error(file, "a NIfTI file", "a NIfTI-1 or NIfTI-2 header");
}

Result<DenseFile> open_nifti(const files::InputFile& file) {
  const auto content = TRY(files::first_bytes(file, files::kStartBytes));
  if (const auto header = parse_header(content)) return open_with_header(file, *header);
  if (!has_extension(file.path(), ".img") && !has_extension(file.path(), ".img.gz")) return fail_no_header(file);

  // The image file of a pair was given; the header is in the other file.
  const auto path = TRY(find_partner(file, ".hdr"));
  const auto partner = TRY(files::InputFile::open(path, file.context()));
  const auto partner_content = TRY(files::first_bytes(partner, files::kStartBytes));
  const auto header = parse_header(partner_content);
  return header ? open_with_header(partner, *header) : Result<DenseFile>(fail_no_header(partner));
}

class NiftiFormat final : public DenseFormat {
 public:
  NiftiFormat()
      : DenseFormat({.id = "nifti",
                     .title = "NIfTI-1 and NIfTI-2, also gzip and pairs",
                     .extensions = {".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"},
                     .has_volumes = true,
                     .has_components = true,
                     .library = "nifti2"}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return parse_header(start.bytes).has_value();
  }

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file,
                                              const ReadOptions& /*options*/) const override {
    return open_nifti(file);
  }
};

}  // namespace

const VolumeFormat& nifti_format() {
  static const NiftiFormat format;
  return format;
}

}  // namespace isoextract::volume_io
