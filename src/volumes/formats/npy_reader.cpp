// NumPy's array files (.npy): a header, the samples. Debian has no library for them. Objects are refused, never
// unpickled.
#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "volumes/detail/dense_format.hpp"
#include "volumes/detail/file_start.hpp"
#include "volumes/detail/formats.hpp"
#include "volumes/formats/npy_header.hpp"

namespace isoextract::volumes {
namespace {

struct NpyType {
  field::SampleType type;
  std::endian endian;
};

std::optional<NpyType> parse_descr(std::string_view descr) {
  constexpr std::array<std::pair<std::string_view, field::SampleType>, 9> kTypes{{{"u1", field::SampleType::u8},
                                                                                  {"i1", field::SampleType::i8},
                                                                                  {"u2", field::SampleType::u16},
                                                                                  {"i2", field::SampleType::i16},
                                                                                  {"u4", field::SampleType::u32},
                                                                                  {"i4", field::SampleType::i32},
                                                                                  {"f2", field::SampleType::f16},
                                                                                  {"f4", field::SampleType::f32},
                                                                                  {"f8", field::SampleType::f64}}};
  if (descr.size() != 3) return std::nullopt;
  const auto* const found =
      std::ranges::find(kTypes, descr.substr(1), &std::pair<std::string_view, field::SampleType>::first);
  if (found == kTypes.end()) return std::nullopt;
  switch (descr.front()) {
    case '<': return NpyType{found->second, std::endian::little};
    case '>': return NpyType{found->second, std::endian::big};
    case '=':
    case '|': return NpyType{found->second, std::endian::native};
    default: return std::nullopt;
  }
}

Result<DenseFile> open_npy(const files::InputFile& file) {
  const auto header = read_npy_header(file);
  if (!header) return tl::unexpected(header.error());
  const auto type = parse_descr(header->descr);
  if (!type) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected numbers of type u1, i1, u2, i2, u4, i4, f2, f4 or f8, found {}", file.name(),
                            printable(header->descr, 40)),
                header->fields.empty() ? Hint("convert the array in NumPy, for example with a.astype('f4')")
                                       : Hint(Remedy::read_as_particles));
  }

  DenseFile dense;
  std::vector<std::uint64_t> shape = header->shape;
  const std::size_t axes = shape.size();
  while (shape.size() > 3 && shape.front() == 1) shape.erase(shape.begin());
  const std::size_t kept = shape.size();
  if (kept != 3 && kept != 4) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected an array with 3 axes [z, y, x], or 4 [t, z, y, x], found shape ({})",
                            file.name(), fmt::join(header->shape, ", ")),
                kept <= 2 ? Hint(Remedy::read_as_particles) : Hint());
  }
  if (axes > kept) dense.notes.push_back(fmt::format("{} leading axes of length 1 were dropped", axes - kept));
  if (kept == 4) {
    dense.volumes = shape.front();
    shape.erase(shape.begin());
  }
  const auto dims = checked_dims(file.name(), {shape[2], shape[1], shape[0]}, type->type);
  if (!dims) return tl::unexpected(dims.error());
  if (auto fine = check_volume_count(file.name(), *dims, type->type, dense.volumes); !fine) {
    return tl::unexpected(fine.error());
  }

  dense.format = "NPY";
  dense.type = type->type;
  dense.dims = *dims;
  dense.endian = type->endian;
  // The order of storage, not of the axes: [t, z, y, x] all the same, but its first axis is the fastest.
  dense.x_slowest = header->fortran_order;
  dense.interleaved = header->fortran_order;
  dense.pieces = {{file.path(), header->data_offset}};
  dense.size_is_exact = true;
  return dense;
}

class NpyFormat final : public DenseFormat {
 public:
  NpyFormat()
      : DenseFormat({.id = "npy",
                     .title = "NumPy array [z, y, x] or [t, z, y, x]",
                     .extensions = {".npy"},
                     .has_volumes = true}) {}

  [[nodiscard]] bool probe(const FileStart& start) const override {
    return !start.packed && starts_with(start.bytes, kNpyMagic);
  }

 protected:
  [[nodiscard]] Result<DenseFile> open_header(const files::InputFile& file,
                                              const ReadOptions& /*options*/) const override {
    return open_npy(file);
  }
};

}  // namespace

const VolumeFormat& npy_format() {
  static const NpyFormat format;
  return format;
}

}  // namespace isoextract::volumes
