#include "volumes/volume_reader.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "field/demo_field.hpp"
#include "volumes/detail/volume_detect.hpp"
#include "volumes/detail/volume_format.hpp"

namespace isoextract::volumes {
namespace {

constexpr std::array<VolumeFormatInfo, 6> kFormats{{
    {VolumeFormat::vdb, "vdb", ".vdb", "OpenVDB grids of float, double or int32"},
    {VolumeFormat::nrrd, "nrrd", ".nrrd .nhdr", "NRRD, attached or detached, raw or gzip"},
    {VolumeFormat::nifti, "nifti", ".nii .nii.gz .hdr .img .hdr.gz .img.gz",
     "NIfTI-1 and NIfTI-2, also gzip and pairs"},
    {VolumeFormat::npy, "npy", ".npy", "NumPy array [z, y, x]"},
    {VolumeFormat::raw, "raw", ".raw", "samples without a header, with --dims and --dtype"},
    {VolumeFormat::demo, "demo", "", "demo:NAME, a field by formula"},
}};

constexpr const char* kPlaceByHand = "place the volume with --spacing X,Y,Z and --origin X,Y,Z";

bool is_demo(const std::string& input) { return input.starts_with(field::kDemoPrefix); }

// Options that belong to one format are an error for the others: they would do nothing, in silence.
Result<void> check_options(const std::string& input, VolumeFormat format, const ReadOptions& options) {
  const std::string_view name = volume_format_name(format);
  if (options.raw && format != VolumeFormat::raw) {
    return fail(
        ErrorKind::usage,
        fmt::format("{}: --dims, --dtype, --endian and --skip are for raw files, this is read as {}", input, name),
        format == VolumeFormat::demo ? "" : "--input-format raw reads the bytes of any file");
  }
  if (options.grid && format != VolumeFormat::vdb) {
    return fail(ErrorKind::usage, fmt::format("{}: --grid is for VDB files, this is read as {}", input, name),
                "leave --grid out: there is one volume in the file");
  }
  if (format == VolumeFormat::raw && !options.raw) {
    return fail(ErrorKind::usage, fmt::format("{}: a raw file does not say what is in it", input),
                "give --dims X,Y,Z and --dtype TYPE (and --endian, --skip, --spacing where they matter)");
  }
  if (options.spacing) {
    for (int axis = 0; axis < 3; ++axis) {
      const double value = (*options.spacing)[axis];
      if (!(std::isfinite(value) && value > 0)) {
        return fail(ErrorKind::usage, fmt::format("--spacing: expected numbers greater than 0, found {}", value));
      }
    }
  }
  if (options.origin && !(std::isfinite(options.origin->x + options.origin->y + options.origin->z))) {
    return fail(ErrorKind::usage, "--origin: expected finite numbers");
  }
  return {};
}

Result<DenseFile> open_dense(const files::InputFile& file, VolumeFormat format, const ReadOptions& options) {
  switch (format) {
    case VolumeFormat::nrrd: return open_nrrd(file);
    case VolumeFormat::nifti: return open_nifti(file);
    case VolumeFormat::npy: return open_npy(file);
    default: return open_raw(file, *options.raw);
  }
}

// The name of a file without its folder and the extensions of its format.
std::string stem_of(const std::filesystem::path& path) {
  std::filesystem::path stem = path.stem();
  if (path.extension() == ".gz") stem = stem.stem();
  return stem.string();
}

// Mapped where that can be; else read, and held against the memory limit. A mapping needs no memory of its own: the
// system keeps what is in use of it and drops the rest where memory is short.
Result<field::DenseSamples> load_samples(const files::InputFile& file, DenseFile& dense, const SampleSource& source,
                                         const ReadOptions& options) {
  if (!dense.x_slowest) {
    if (auto mapped = map_samples(source, options.progress)) {
      const auto mapping = std::make_shared<const files::MappedFile>(std::move(*mapped));
      return field::DenseSamples{dense.type, dense.dims, mapping, mapping->data(), true};
    }
  }
  const std::uint64_t needed = source.bytes + (dense.x_slowest ? transpose_bytes(dense.dims, source.sample_size) : 0);
  const std::string what = fmt::format("{}: {}", file.name(), describe_samples(dense.dims, dense.type));
  if (auto fits = check_memory(needed, options.limits, what); !fits) return tl::unexpected(fits.error());

  auto read = dense.x_slowest ? read_samples_transposed(source, dense.dims, options.progress)
                              : read_samples(source, options.progress);
  if (!read) return tl::unexpected(read.error());
  if (read->more_in_gzip) dense.notes.emplace_back("bytes after the samples were not read");
  const auto data = std::make_shared<const Buffer<std::byte>>(std::move(read->data));
  return field::DenseSamples{dense.type, dense.dims, data, data->data(), false};
}

Result<field::ScalarField> load_dense(const files::InputFile& file, DenseFile&& dense, const ReadOptions& options) {
  const std::string what = describe_samples(dense.dims, dense.type);
  SampleSource source;
  source.pieces = std::move(dense.pieces);
  source.bytes = sample_bytes(dense.dims, dense.type);
  source.sample_size = field::sample_size(dense.type);
  source.swap_bytes = dense.endian != std::endian::native && source.sample_size > 1;

  auto extra = check_source(source, what);
  if (!extra) {
    if (extra.error().hint.empty()) extra.error().hint = dense.size_hint;
    return tl::unexpected(extra.error());
  }
  if (*extra > 0) {
    if (dense.size_is_exact) {
      return fail(
          ErrorKind::input,
          fmt::format("{}: expected {} bytes ({}), found {} more after them", file.name(), source.bytes, what, *extra),
          dense.size_hint);
    }
    dense.notes.push_back(fmt::format("{} bytes after the samples were not read", *extra));
  }
  auto samples = load_samples(file, dense, source, options);
  if (!samples) return tl::unexpected(samples.error());

  field::ScalarField field;
  field.source = file.name();
  field.name = stem_of(file.path());
  field.format = std::move(dense.format);
  field.world_space = std::move(dense.world_space);
  field.scale = dense.scale;
  field.notes = std::move(dense.notes);
  field.samples = std::move(*samples);
  if (auto placed = set_frame(field, dense.frame, options); !placed) return tl::unexpected(placed.error());
  return field;
}

Result<field::ScalarField> read_demo(const std::string& input, const ReadOptions& options) {
  auto field = field::make_demo_field(input, options.limits, options.progress);
  if (!field) return field;
  if (auto placed = set_frame(*field, {field->index_to_world, {}}, options); !placed) {
    return tl::unexpected(placed.error());
  }
  return field;
}

Result<field::ScalarField> read_file(const std::string& input, const ReadOptions& options) {
  const auto file = files::InputFile::open(input);
  if (!file) return tl::unexpected(file.error());
  const auto detected = detect_format(*file, options);
  if (!detected) return tl::unexpected(detected.error());
  if (auto fine = check_options(input, detected->format, options); !fine) return tl::unexpected(fine.error());

  Result<field::ScalarField> field = [&]() -> Result<field::ScalarField> {
    if (detected->format == VolumeFormat::vdb) return read_vdb(*file, options);
    auto dense = open_dense(*file, detected->format, options);
    if (!dense) return tl::unexpected(dense.error());
    return load_dense(*file, std::move(*dense), options);
  }();
  if (field && !detected->note.empty()) field->notes.insert(field->notes.begin(), detected->note);
  return field;
}

Result<field::ScalarField> read_any(const std::string& input, const ReadOptions& options) {
  auto field = [&]() -> Result<field::ScalarField> {
    if (!is_demo(input)) return read_file(input, options);
    if (auto fine = check_options(input, VolumeFormat::demo, options); !fine) return tl::unexpected(fine.error());
    return read_demo(input, options);
  }();
  if (!field) return field;
  field->source = input;
  if (options.kind) field->kind = *options.kind;
  return field;
}

Result<std::vector<GridInfo>> list_file(const std::string& input, const ReadOptions& options) {
  const auto file = files::InputFile::open(input);
  if (!file) return tl::unexpected(file.error());
  const auto detected = detect_format(*file, options);
  if (!detected) return tl::unexpected(detected.error());
  if (auto fine = check_options(input, detected->format, options); !fine) return tl::unexpected(fine.error());
  if (detected->format == VolumeFormat::vdb) return list_vdb_grids(*file, options.limits);

  const auto dense = open_dense(*file, detected->format, options);
  if (!dense) return tl::unexpected(dense.error());
  GridInfo info;
  info.name = stem_of(file->path());
  info.type = field::sample_type_name(dense->type);
  info.scalar = true;
  info.box = {glm::ivec3(0), dense->dims - 1};
  info.voxels = sample_bytes(dense->dims, dense->type) / field::sample_size(dense->type);
  return std::vector{info};
}

// Demo fields hold density unless the options say otherwise; their samples are not made here.
Result<std::vector<GridInfo>> list_demo(const std::string& input, const ReadOptions& options) {
  if (auto fine = check_options(input, VolumeFormat::demo, options); !fine) return tl::unexpected(fine.error());
  const auto demo = field::parse_demo_spec(input);
  if (!demo) return tl::unexpected(demo.error());
  GridInfo info;
  info.name = std::string(demo->name);
  info.type = field::sample_type_name(field::SampleType::f32);
  info.scalar = true;
  info.kind = options.kind.value_or(field::FieldKind::density);
  info.box = {glm::ivec3(0), glm::ivec3(demo->size - 1)};
  info.voxels = sample_bytes(glm::ivec3(demo->size), field::SampleType::f32) / sizeof(float);
  return std::vector{info};
}

Result<std::vector<GridInfo>> list_any(const std::string& input, const ReadOptions& options) {
  return is_demo(input) ? list_demo(input, options) : list_file(input, options);
}

Result<std::vector<std::filesystem::path>> list_files(const std::string& input, const ReadOptions& options) {
  std::vector<std::filesystem::path> files;
  if (is_demo(input)) return files;
  files.emplace_back(input);
  const auto file = files::InputFile::open(input);
  if (!file) return tl::unexpected(file.error());
  const auto detected = detect_format(*file, options);
  if (!detected) return tl::unexpected(detected.error());
  if (auto fine = check_options(input, detected->format, options); !fine) return tl::unexpected(fine.error());
  if (detected->format == VolumeFormat::vdb) return files;
  const auto dense = open_dense(*file, detected->format, options);
  if (!dense) return tl::unexpected(dense.error());
  for (const SamplePiece& piece : dense->pieces) files.push_back(piece.path);
  return files;
}

// The border that no exception of a library crosses.
template <class F>
auto guarded(const std::string& input, F&& work) -> decltype(work()) {
  try {
    return work();
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::input, input + ": not enough memory to read it");
  } catch (const std::exception& error) {
    return fail(ErrorKind::input, fmt::format("{}: {}", input, error.what()));
  }
}

}  // namespace

std::span<const VolumeFormatInfo> volume_formats() { return kFormats; }

Result<std::vector<GridInfo>> list_grids(const std::string& input, const ReadOptions& options) {
  return guarded(input, [&] { return list_any(input, options); });
}

Result<std::vector<std::filesystem::path>> list_input_files(const std::string& input, const ReadOptions& options) {
  return guarded(input, [&] { return list_files(input, options); });
}

Result<field::ScalarField> read_volume(const std::string& input, const ReadOptions& options) {
  return guarded(input, [&] { return read_any(input, options); });
}

Result<glm::ivec3> checked_dims(const std::string& file, const std::array<std::uint64_t, 3>& sizes,
                                field::SampleType type) {
  constexpr std::uint64_t kMaxSize = 0x7fffffff;
  constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 62;
  const auto bytes = checked_product(sizes[0], sizes[1], sizes[2], std::uint64_t{field::sample_size(type)});
  const bool fits = std::ranges::all_of(sizes, [](std::uint64_t size) { return size >= 1 && size <= kMaxSize; });
  if (!fits || !bytes || *bytes > kMaxBytes) {
    return fail(ErrorKind::input, fmt::format("{}: expected sizes from 1 to {} along each axis, found {}x{}x{}", file,
                                              kMaxSize, sizes[0], sizes[1], sizes[2]));
  }
  return glm::ivec3(static_cast<int>(sizes[0]), static_cast<int>(sizes[1]), static_cast<int>(sizes[2]));
}

std::uint64_t sample_bytes(const glm::ivec3& dims, field::SampleType type) {
  return static_cast<std::uint64_t>(dims.x) * static_cast<std::uint64_t>(dims.y) * static_cast<std::uint64_t>(dims.z) *
         field::sample_size(type);
}

std::string describe_samples(const glm::ivec3& dims, field::SampleType type) {
  return fmt::format("{}x{}x{} {} samples", dims.x, dims.y, dims.z, field::sample_type_name(type));
}

Result<void> set_frame(field::ScalarField& field, const Frame& frame, const ReadOptions& options) {
  field::Affine affine = frame.index_to_world;
  if (options.spacing) {
    // An axis-aligned frame has no other entries than those that the spacing replaces.
    const glm::dmat3 diagonal = field::scaling({affine.linear[0][0], affine.linear[1][1], affine.linear[2][2]}).linear;
    const bool mirrored = affine.linear[0][0] < 0 || affine.linear[1][1] < 0 || affine.linear[2][2] < 0;
    if (!frame.problem.empty()) {
      field.notes.push_back(fmt::format("--spacing replaces the frame of the file ({})", frame.problem));
      affine = {};
    } else if (affine.linear != diagonal || mirrored) {
      field.notes.emplace_back("--spacing replaces the rotated, sheared or mirrored axes of the file");
    }
    affine.linear = field::scaling(*options.spacing).linear;
  } else if (!frame.problem.empty()) {
    return fail(ErrorKind::input, fmt::format("{}: {}", field.source, frame.problem), kPlaceByHand);
  }
  if (options.origin) affine.offset = *options.origin;
  if (!affine.is_regular()) {
    return fail(ErrorKind::input, field.source + ": the axes of the volume are flat or not finite in the world",
                kPlaceByHand);
  }
  field.index_to_world = affine;
  return {};
}

}  // namespace isoextract::volumes
