#include "volume_io/volume_writer.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include <fmt/format.h>

#include "files/output_file.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_reader.hpp"
#include "volume_io/write/dense_writers.hpp"

namespace isoextract::volume_io {
namespace {

tl::unexpected<Error> cannot_hold(const std::filesystem::path& path, VolumeFileFormat format, const std::string& what) {
  return fail(ErrorCode::output, fmt::format("{}: {} files cannot store {}", path.string(), word_of(format), what));
}

// The text before and after the samples.
struct Surroundings {
  std::string header;
  std::string_view trailer = {};
};

Result<Surroundings> surroundings_of(const std::filesystem::path& path, const field::ScalarField& field,
                                     const field::DenseSamples& samples, VolumeFileFormat format) {
  if (!can_store(format, samples.type)) return cannot_hold(path, format, "16-bit floats");
  switch (format) {
    case VolumeFileFormat::npy: return Surroundings{npy_header(samples)};
    case VolumeFileFormat::nrrd: return Surroundings{nrrd_header(field, samples)};
    case VolumeFileFormat::vti:
      if (!has_perpendicular_axes(field.index_to_world)) {
        return cannot_hold(path, format, "axes that are not perpendicular");
      }
      return Surroundings{vti_header(field, samples), kVtiTrailer};
    case VolumeFileFormat::raw:
    case VolumeFileFormat::vdb: break;
  }
  return Surroundings{};
}

}  // namespace

std::optional<VolumeFileFormat> volume_file_format_by_path(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  if (extension.empty()) return std::nullopt;
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return value_of<VolumeFileFormat>(extension.substr(1));
}

bool can_store(VolumeFileFormat format, field::SampleType type) {
  return type != field::SampleType::f16 || (format != VolumeFileFormat::nrrd && format != VolumeFileFormat::vti);
}

Result<std::uint64_t> write_volume(const std::filesystem::path& path, std::span<const field::ScalarField> fields,
                                   VolumeFileFormat format, const Context& context) {
  if (format == VolumeFileFormat::vdb) return write_vdb(path, fields, context);
  if (fields.size() != 1) return cannot_hold(path, format, fmt::format("{} fields", fields.size()));
  const field::ScalarField& field = fields.front();
  const auto* samples = std::get_if<field::DenseSamples>(&field.samples);
  if (samples == nullptr) return cannot_hold(path, format, "sparse fields");
  if (!field.scale.is_identity()) return cannot_hold(path, format, "a value scale (slope and intercept)");
  const auto around = TRY(surroundings_of(path, field, *samples, format));
  auto file = TRY(files::OutputFile::create(path));
  TRY(file.write(around.header));
  const std::span bytes(static_cast<const std::byte*>(samples->data),
                        samples->count() * field::sample_size(samples->type));
  TRY(file.write(bytes));
  TRY(file.write(around.trailer));
  TRY(check_mapping_intact(field));
  const std::uint64_t count = file.bytes_written();
  TRY(file.commit());
  return count;
}

}  // namespace isoextract::volume_io
