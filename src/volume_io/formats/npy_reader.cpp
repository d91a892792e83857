// NumPy's array files (.npy): a header and the samples. Debian has no library for them. Rejects Python objects, which
// would need unpickling.
#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "volume_io/detail/dense_format.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/formats/npy_volume.hpp"

namespace isoextract::volume_io {
namespace {

struct NpyType {
  field::SampleType type = field::SampleType::u8;
  std::endian endian = std::endian::native;
  Integer64 wide = Integer64::none;
  std::uint64_t numbers = 1;  // components per element
};

std::optional<NpyType> parse_descr(std::string_view descr) {
  using enum field::SampleType;
  constexpr std::array<std::pair<std::string_view, NpyType>, 14> kTypes{
      {{"b1", {u8}},
       {"u1", {u8}},
       {"i1", {i8}},
       {"u2", {u16}},
       {"i2", {i16}},
       {"u4", {u32}},
       {"i4", {i32}},
       {"u8", {f64, std::endian::native, Integer64::u64}},
       {"i8", {f64, std::endian::native, Integer64::i64}},
       {"f2", {f16}},
       {"f4", {f32}},
       {"f8", {f64}},
       {"c8", {f32, std::endian::native, Integer64::none, 2}},
       {"c16", {f64, std::endian::native, Integer64::none, 2}}}};
  if (descr.empty()) return std::nullopt;
  const auto* const found = std::ranges::find(kTypes, descr.substr(1), &std::pair<std::string_view, NpyType>::first);
  if (found == kTypes.end()) return std::nullopt;
  NpyType type = found->second;
  switch (descr.front()) {
    case '<': type.endian = std::endian::little; return type;
    case '>': type.endian = std::endian::big; return type;
    case '=':
    case '|': return type;
    default: return std::nullopt;
  }
}

// The axes of an array by meaning.
struct NpyAxes {
  std::array<std::uint64_t, 3> sizes{};  // x, y, z
  std::optional<std::uint64_t> volumes;
  std::optional<std::uint64_t> components;
};

Hint read_as_vectors(const NpyHeader& header) {
  const std::uint64_t count = header.shape.back();
  return {Remedy::set, Setting::component,
          fmt::format("0 to {}, or length, if the last axis (length {}) holds the components of a vector", count - 1,
                      count)};
}

Result<NpyAxes> find_axes(const std::string& name, const NpyHeader& header, bool has_component, AxisOrder order,
                          bool is_flat, Notes& notes) {
  std::vector<std::uint64_t> shape = header.shape;
  if (is_flat && shape.size() == 2) shape.insert(order == AxisOrder::zyx ? shape.begin() : shape.end(), 1);
  const std::size_t wanted = has_component ? 4 : 3;  // one more with volumes
  while (shape.size() > wanted && shape.front() == 1) shape.erase(shape.begin());
  const std::size_t kept = shape.size();
  const std::string_view letters = order == AxisOrder::zyx ? "z, y, x" : "x, y, z";
  if (kept != wanted && kept != wanted + 1) {
    const std::string_view c = has_component ? ", c" : "";
    return fail(ErrorCode::input,
                fmt::format("{}: expected an array with {} axes [{}{}], or {} [t, {}{}], found shape ({})", name,
                            wanted, letters, c, wanted + 1, letters, c, fmt::join(header.shape, ", ")),
                kept < 2    ? Hint("a volume has at least three axes: reshape the array in NumPy first")
                : kept == 2 ? Hint{"a volume has at least three axes",
                                   {Remedy::use, Setting::particle_method},
                                   {Remedy::use, Setting::height_field}}
                : kept == 5 && !has_component ? read_as_vectors(header)
                                              : Hint("take a part with fewer axes in NumPy first, for example a[0]"));
  }
  if (header.shape.size() > kept) {
    notes.push_back({NoteId::axes_dropped,
                     fmt::format("the reader drops {} leading axes of length 1", header.shape.size() - kept)});
  }
  NpyAxes axes;
  if (kept == wanted + 1) {
    axes.volumes = shape.front();
    shape.erase(shape.begin());
  }
  if (has_component) axes.components = shape[3];
  axes.sizes = {shape[0], shape[1], shape[2]};
  if (order == AxisOrder::zyx) std::swap(axes.sizes[0], axes.sizes[2]);
  return axes;
}

class NpyFormat final : public DenseFormat {
 public:
  NpyFormat()
      : DenseFormat({.id = "npy",
                     .title = "NumPy array [z, y, x] or [t, z, y, x]",
                     .extensions = {".npy"},
                     .has_volumes = true,
                     .has_components = true,
                     .has_axis_order = true}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return !start.packed && files::starts_with(start.bytes, kNpyMagic);
  }

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file, const ReadOptions& options) const override {
    const auto header = TRY(read_npy_header(file));
    auto dense = npy_volume(file.name(), header, options);
    if (dense) dense->pieces = {{file.path(), header.data_offset}};
    return dense;
  }
};

}  // namespace

Result<DenseFile> npy_volume(const std::string& name, const NpyHeader& header, const ReadOptions& options) {
  const auto type = parse_descr(header.descr);
  if (!type) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected numbers of type b1, u1, i1, u2, i2, u4, i4, u8, i8, f2, f4, f8, c8 or c16, "
                            "found {}",
                            name, printable(header.descr, 40)),
                header.fields.empty() ? Hint("convert the array in NumPy, for example with a.astype('f4')")
                                      : Hint(Remedy::use, Setting::particle_method));
  }
  DenseFile dense;
  const AxisOrder order = options.axis_order.value_or(AxisOrder::zyx);
  const bool is_complex = type->numbers > 1;
  const bool has_component_axis = options.component.has_value() && !is_complex && header.shape.size() > 3;
  const auto axes = TRY(find_axes(name, header, has_component_axis, order, options.flat, dense.notes));
  const auto dims = TRY(checked_dims(name, axes.sizes, type->type));
  dense.volumes = axes.volumes.value_or(1);
  dense.components = axes.components.value_or(type->numbers);
  if (is_complex) dense.component_names = "the real and the imaginary part";
  const std::uint64_t count = checked_product(dense.volumes, dense.components).value_or(0);
  TRY(check_volume_count(name, dims, type->type, count));

  constexpr std::uint64_t kFewComponents = 4;
  const bool looks_like_vectors = header.shape.back() <= kFewComponents && dense.volumes > kFewComponents &&
                                  std::ranges::min(header.shape) == header.shape.back();
  if (looks_like_vectors && !options.component && !is_complex) {
    dense.other_interpretation = read_as_vectors(header);
  }
  dense.format = "NPY";
  dense.type = type->type;
  dense.wide = type->wide;
  dense.dims = dims;
  dense.endian = type->endian;
  // Axes are [t, z, y, x] in either storage order; Fortran order makes the first one the fastest.
  dense.x_slowest = header.fortran_order == (order == AxisOrder::zyx);
  dense.interleaved = header.fortran_order;
  dense.components_interleaved = !header.fortran_order || is_complex;
  dense.size_is_exact = true;
  dense.frame.stated = false;
  return dense;
}

const VolumeFormat& npy_format() {
  static const NpyFormat format;
  return format;
}

}  // namespace isoextract::volume_io
