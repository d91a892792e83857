#include "volume_io/detail/dense_reading.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/detail/label_ids.hpp"
#include "volume_io/detail/mapped_layers.hpp"
#include "volume_io/detail/sample_store.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::size_t kSamplesAtOnce = std::size_t{1} << 16;

// Returns whether double represents the value exactly: all up to 2^53, and larger ones with enough trailing zero bits.
template <class T>
bool is_exact(T value) {
  const auto as_double = static_cast<double>(value);
  constexpr double kEnd = std::is_signed_v<T> ? 0x1p63 : 0x1p64;
  return as_double < kEnd && static_cast<T>(as_double) == value;
}

// Converts 64-bit integers to double in place (both have eight bytes). Fails for inexact values other than `no_data`.
template <class T>
Result<void> widen(const files::InputFile& file, const glm::ivec3& dims, SampleStore& store,
                   std::optional<double> no_data) {
  const std::span<std::byte> bytes = store.bytes();
  const std::size_t count = bytes.size() / sizeof(T);
  std::atomic<std::size_t> first_bad{count};
  for_each_range(count, kSamplesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      T value{};
      std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
      const auto as_double = static_cast<double>(value);
      if (!is_exact(value) && as_double != no_data) {
        std::size_t known = first_bad.load();
        while (i < known && !first_bad.compare_exchange_weak(known, i)) {
        }
        return;
      }
      std::memcpy(bytes.data() + i * sizeof value, &as_double, sizeof as_double);
    }
    store.leave(bytes.subspan(begin * sizeof(T), (end - begin) * sizeof(T)));
  });
  const std::size_t bad = first_bad;
  if (bad == count) return {};
  T value{};
  std::memcpy(&value, bytes.data() + bad * sizeof value, sizeof value);
  const auto nx = static_cast<std::size_t>(dims.x);
  const auto ny = static_cast<std::size_t>(dims.y);
  return fail(
      ErrorCode::input,
      fmt::format(
          "{}: expected integers that a double represents exactly (all up to 2^53, above 2^53 only some), found {} "
          "at sample ({}, {}, {})",
          file.name(), value, bad % nx, bad / nx % ny, bad / nx / ny),
      "subtract a common offset from the values, or divide them; renumber the ids of a label map");
}

Result<bool> read_into(SampleStore& store, const DenseFile& dense, const SampleSource& source, const Context& context) {
  return dense.x_slowest ? read_samples_transposed(source, dense.dims, store, context)
                         : read_samples(source, store, context);
}

// Maps the samples if possible, else reads them. A mapping needs no reserved memory: the system keeps the pages in use
// and drops other pages when memory is short. With ReadOptions::by_layers, maps layers if the address space is too
// small for the whole file and other work.
Result<field::DenseSamples> load_samples(const files::InputFile& file, const DenseFile& dense,
                                         const SampleSource& source, bool last, const ReadOptions& options,
                                         Notes& notes) {
  const Context& context = file.context();
  if (!dense.x_slowest && dense.wide == Integer64::none) {
    const bool prefers_layers = options.by_layers && fills_address_space(source);
    const auto map_whole = [&]() -> std::optional<field::DenseSamples> {
      auto mapped = map_samples(source, context);
      if (!mapped) return std::nullopt;
      const auto mapping = std::make_shared<const files::MappedFile>(std::move(*mapped));
      return field::DenseSamples{dense.type, dense.dims, mapping, mapping->data(), true, &mapping->lost()};
    };
    std::optional<field::DenseSamples> samples;
    if (!prefers_layers) samples = map_whole();
    if (!samples && options.by_layers) samples = map_layers(source, dense.type, dense.dims, context, notes);
    if (!samples && prefers_layers) samples = map_whole();
    if (samples) return std::move(*samples);
  }
  auto store = TRY(SampleStore::make(file.name(), dense.dims, dense.type, context));
  const bool has_trailing_data = TRY(read_into(store, dense, source, context));
  if (has_trailing_data && last && source.pieces.back().gzip)
    notes.push_back({NoteId::extra_bytes, "the reader skips the bytes after the samples"});
  if (dense.wide != Integer64::none) {
    TRY(dense.wide == Integer64::i64 ? widen<std::int64_t>(file, dense.dims, store, options.no_data)
                                     : widen<std::uint64_t>(file, dense.dims, store, options.no_data));
  }
  return std::move(store).finish(notes);
}

// Reads or maps 64-bit ids. Keeps only their indices, and the table of the ids in `ids`.
Result<field::DenseSamples> load_ids(const files::InputFile& file, const DenseFile& dense, const SampleSource& source,
                                     field::LabelIdTable& ids, Notes& notes) {
  const Context& context = file.context();
  field::DenseSamples wide;
  auto mapped = dense.x_slowest ? std::nullopt : map_samples(source, context);
  if (mapped) {
    const auto mapping = std::make_shared<const files::MappedFile>(std::move(*mapped));
    wide = {dense.type, dense.dims, mapping, mapping->data(), true, &mapping->lost()};
  } else {
    const std::uint64_t index_bytes = sample_bytes(dense.dims, field::SampleType::u32);
    auto store = TRY(SampleStore::make(file.name(), dense.dims, dense.type, context, {}, index_bytes));
    TRY(read_into(store, dense, source, context));
    wide = std::move(store).finish(notes);
  }
  IndexedIds indexed = TRY(index_ids(wide, dense.wide, file.name(), context, notes));
  ids = std::move(indexed.ids);
  return std::move(indexed.samples);
}

// Returns the source of all samples.
SampleSource source_of(const DenseFile& dense) {
  SampleSource source;
  source.pieces = dense.pieces;
  source.bytes = sample_bytes(dense.dims, dense.type) * dense.components * dense.volumes;
  source.sample_size = field::sample_size(dense.type);
  source.swap_bytes = dense.endian != std::endian::native && source.sample_size > 1;
  return source;
}

// Returns the source of the samples of one volume and component.
Result<SampleSource> part_of(const SampleSource& all, const DenseFile& dense, std::uint64_t volume,
                             std::uint64_t component) {
  const Share volumes{volume, dense.volumes};
  const Share components{component, dense.components};
  // Combines the volume and component indices, for when both axes are on the same side of the spatial axes.
  const auto both = [&] {
    const Share& fast = dense.component_before_volume ? components : volumes;
    const Share& slow = dense.component_before_volume ? volumes : components;
    return Share{fast.index + fast.count * slow.index, fast.count * slow.count};
  };
  if (dense.interleaved == dense.components_interleaved) {
    return dense.interleaved ? volume_io::part_of(all, both(), {}) : volume_io::part_of(all, {}, both());
  }
  return dense.interleaved ? volume_io::part_of(all, volumes, components)
                           : volume_io::part_of(all, components, volumes);
}

template <class Length, class T>
void add_to_lengths(const field::DenseSamples& samples, const T* component, bool first, const field::ValueScale& scale,
                    SampleStore& store) {
  const std::span lengths(reinterpret_cast<Length*>(store.bytes().data()), samples.count());
  for_each_range(lengths.size(), kSamplesAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const double value = scale(static_cast<double>(component[i]));
      const double before = first ? 0 : static_cast<double>(lengths[i]);
      // hypot() returns infinity for infinity and NaN.
      const double length = std::isnan(value) || std::isnan(before) ? std::numeric_limits<double>::quiet_NaN()
                                                                    : std::hypot(before, value);
      lengths[i] = static_cast<Length>(length);
    }
    store.leave(std::as_bytes(lengths.subspan(begin, end - begin)));
    samples.leave(begin, end);
  });
}

// Reads one component after another, so that only one of them is in memory besides the lengths.
template <class Length, class Load>
Result<field::DenseSamples> read_lengths(const files::InputFile& file, const DenseFile& dense, const Load& load,
                                         Notes& notes) {
  auto store = TRY(SampleStore::make(file.name(), dense.dims, field::sample_type_of<Length>(), file.context(),
                                     "lengths of ", sample_bytes(dense.dims, dense.type)));
  for (std::uint64_t c = 0; c < dense.components; ++c) {
    const Result<field::DenseSamples> component = load(c);
    if (!component) return component;
    field::visit_sample_type(component->type, [&]<class T>(std::type_identity<T>) {
      add_to_lengths<Length>(*component, static_cast<const T*>(component->data), c == 0, dense.scale, store);
    });
    if (component->lost()) {
      return fail(ErrorCode::input, file.name() + ": the file became shorter, or reading it failed, during the run");
    }
  }
  return std::move(store).finish(notes);
}

bool needs_double(field::SampleType type) {
  return type == field::SampleType::f64 || type == field::SampleType::u32 || type == field::SampleType::i32;
}

}  // namespace

Result<std::vector<files::FilePart>> find_volume_parts(const files::InputFile& file, const DenseFile& dense,
                                                       const ReadOptions& options) {
  std::vector<files::FilePart> parts{{file.path(), {}}};
  const auto whole_files = [&] {
    for (const SamplePiece& piece : dense.pieces) parts.push_back({piece.path, {}});
    return parts;
  };
  const bool is_run =
      !dense.interleaved && (dense.components == 1 || dense.components_interleaved || dense.component_before_volume);
  const bool is_packed = std::ranges::any_of(dense.pieces, &SamplePiece::packed);
  if (!options.volume || dense.volumes == 1 || !is_run || is_packed) return whole_files();
  const auto volume = TRY(choose_volume(file.name(), dense.volumes, options.volume, dense.other_interpretation));
  const SampleSource one = TRY(volume_io::part_of(source_of(dense), {}, {volume, dense.volumes}));
  std::uint64_t header = file.size();
  for (const SamplePiece& piece : dense.pieces) {
    if (piece.path == file.path()) header = std::min(header, piece.offset);
  }
  if (header > 0) parts.front().ranges.push_back({0, header});
  for (const SamplePiece& piece : one.pieces) {
    const auto known = std::ranges::find(parts, piece.path, &files::FilePart::path);
    files::FilePart& part = known != parts.end() ? *known : parts.emplace_back(files::FilePart{piece.path, {}});
    part.ranges.push_back({piece.offset, one.piece_bytes()});
  }
  return parts;
}

Result<field::ScalarField> read_dense(const files::InputFile& file, DenseFile dense, std::string name,
                                      const ReadOptions& options) {
  const auto volume = TRY(choose_volume(file.name(), dense.volumes, options.volume, dense.other_interpretation));
  const auto chosen = TRY(choose_component(file.name(), dense.components, options.component, dense.component_names));
  std::string what = describe_samples(dense.dims, dense.type);
  if (dense.components > 1) what += fmt::format(" of {} components", dense.components);
  if (dense.volumes > 1) what += fmt::format(" in each of {} volumes", dense.volumes);
  const SampleSource source = source_of(dense);
  const auto extra = TRY(check_source(source, what, file.context()));
  if (extra > 0) {
    if (dense.size_is_exact) {
      return fail(ErrorCode::input, fmt::format("{}: expected {} bytes ({}), found {} more bytes after them",
                                                file.name(), source.bytes, what, extra));
    }
    dense.notes.push_back({NoteId::extra_bytes, fmt::format("the reader skips {} bytes after the samples", extra)});
  }
  const auto load = [&](std::uint64_t component) -> Result<field::DenseSamples> {
    const auto one = TRY(part_of(source, dense, volume, component));
    const bool last = volume + 1 == dense.volumes && component + 1 == dense.components;
    ReadOptions how = options;
    how.by_layers = options.by_layers && chosen && !options.no_data;  // lengths and no-data values need all samples
    return load_samples(file, dense, one, last, how, dense.notes);
  };
  field::LabelIdTable ids;
  const auto load_chosen = [&](std::uint64_t component) -> Result<field::DenseSamples> {
    const bool are_ids = options.label_ids && dense.wide != Integer64::none && !options.no_data;
    if (!are_ids) return load(component);
    return load_ids(file, dense, TRY(part_of(source, dense, volume, component)), ids, dense.notes);
  };
  auto samples = TRY(chosen                     ? load_chosen(*chosen)
                     : needs_double(dense.type) ? read_lengths<double>(file, dense, load, dense.notes)
                                                : read_lengths<float>(file, dense, load, dense.notes));

  field::ScalarField field;
  field.source = file.name();
  field.name = std::move(name);
  field.format = std::move(dense.format);
  field.world_space = std::move(dense.world_space);
  field.length_unit = std::move(dense.length_unit);
  if (chosen) field.scale = dense.scale;
  field.notes = std::move(dense.notes);
  field.samples = std::move(samples);
  field.labels = std::move(dense.labels);
  field.label_ids = std::move(ids);
  TRY(set_placement(field, dense.frame, options));
  return field;
}

}  // namespace isoextract::volume_io
