#include <fmt/format.h>

#include "base/checked.hpp"
#include "volumes/detail/volume_format.hpp"

namespace isoextract::volumes {
namespace {

// What other options would make the file fit; empty where nothing evident does.
std::string fitting_options(const files::InputFile& file, const RawLayout& layout, std::uint64_t expected) {
  const std::uint64_t found = file.size() - std::min(file.size(), layout.skip);
  const std::uint64_t count = expected / field::sample_size(layout.type);
  std::string types;
  for (const field::SampleType type : {field::SampleType::u8, field::SampleType::i8, field::SampleType::u16,
                                       field::SampleType::i16, field::SampleType::u32, field::SampleType::i32,
                                       field::SampleType::f16, field::SampleType::f32, field::SampleType::f64}) {
    if (count * field::sample_size(type) == found)
      types += fmt::format("{}{}", types.empty() ? "" : ", ", field::sample_type_name(type));
  }
  if (!types.empty()) return fmt::format("the size would fit --dtype {}", types);
  if (file.size() > expected) {
    return fmt::format("the size would fit --skip {}, if that many bytes of header come first", file.size() - expected);
  }
  return "check --dims, --dtype and --skip";
}

}  // namespace

Result<DenseFile> open_raw(const files::InputFile& file, const RawLayout& layout) {
  std::array<std::uint64_t, 3> sizes{};
  for (int axis = 0; axis < 3; ++axis) {
    if (layout.dims[axis] < 1) {
      return fail(ErrorKind::usage, fmt::format("--dims: expected three numbers from 1 on, found {},{},{}",
                                                layout.dims.x, layout.dims.y, layout.dims.z));
    }
    sizes[static_cast<std::size_t>(axis)] = static_cast<std::uint64_t>(layout.dims[axis]);
  }
  const auto dims = checked_dims(file.name(), sizes, layout.type);
  if (!dims) return tl::unexpected(dims.error());
  const std::uint64_t expected = sample_bytes(*dims, layout.type);
  const auto total = checked_sum(expected, layout.skip);
  if (!total || *total != file.size()) {
    return fail(ErrorKind::input,
                fmt::format("{}: expected {} bytes ({} after --skip {}), found {}", file.name(),
                            total ? std::to_string(*total) : "more than 2^64", describe_samples(*dims, layout.type),
                            layout.skip, file.size()),
                fitting_options(file, layout, expected));
  }
  DenseFile dense;
  dense.format = "raw";
  dense.type = layout.type;
  dense.dims = *dims;
  dense.endian = layout.endian;
  dense.pieces = {{file.path(), layout.skip}};
  dense.size_is_exact = true;
  return dense;
}

}  // namespace isoextract::volumes
