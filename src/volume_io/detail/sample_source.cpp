#include "volume_io/detail/sample_source.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <functional>
#include <mutex>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/checked.hpp"
#include "base/parallel.hpp"
#include "files/file_bytes.hpp"
#include "files/gzip_stream.hpp"

namespace isoextract::volume_io {
namespace {

constexpr std::size_t kChunk = std::size_t{4} << 20;  // a multiple of every sample size

template <class T, class Swap>
void swap_all(std::span<std::byte> bytes, Swap swap) {
  auto* values = reinterpret_cast<T*>(bytes.data());
  const std::size_t count = bytes.size() / sizeof(T);
  for (std::size_t i = 0; i < count; ++i) values[i] = swap(values[i]);
}

void swap_samples(std::span<std::byte> bytes, std::size_t sample_size) {
  switch (sample_size) {
    case 2: return swap_all<std::uint16_t>(bytes, [](std::uint16_t v) { return __builtin_bswap16(v); });
    case 4: return swap_all<std::uint32_t>(bytes, [](std::uint32_t v) { return __builtin_bswap32(v); });
    case 8: return swap_all<std::uint64_t>(bytes, [](std::uint64_t v) { return __builtin_bswap64(v); });
    default: return;
  }
}

// Calls work(i) for all i < count in parallel; stops at the first error.
Result<void> for_each_parallel(std::size_t count, const std::function<Result<void>(std::size_t)>& work) {
  std::mutex mutex;
  std::optional<Error> error;
  std::atomic<bool> failed{false};
  for_each_index(count, [&](std::size_t i) {
    if (failed.load(std::memory_order_relaxed)) return;
    auto done = work(i);
    if (done) return;
    const std::scoped_lock lock(mutex);
    failed = true;
    if (!error) error = std::move(done.error());
  });
  if (error) return tl::unexpected(std::move(*error));
  return {};
}

template <class T>
void pick_lane(const std::byte* stored, std::span<std::byte> out, const SampleSource& source) {
  for (std::size_t at = 0, from = source.lane * sizeof(T); at < out.size();
       at += sizeof(T), from += source.stride * sizeof(T)) {
    std::memcpy(out.data() + at, stored + from, sizeof(T));
  }
}

void pick_samples(const std::byte* stored, std::span<std::byte> out, const SampleSource& source) {
  switch (source.sample_size) {
    case 1: return pick_lane<std::uint8_t>(stored, out, source);
    case 2: return pick_lane<std::uint16_t>(stored, out, source);
    case 4: return pick_lane<std::uint32_t>(stored, out, source);
    default: return pick_lane<std::uint64_t>(stored, out, source);
  }
}

// Fills `out` with the wanted samples. take(at, bytes) must read stored samples into `bytes`, starting with the one
// wanted at byte `at` of `out`. Without interleaving, reads directly into `out`.
template <class Take>
Result<void> fill_from_lane(std::span<std::byte> out, const SampleSource& source, const Take& take) {
  if (source.stride == 1) return take(std::size_t{0}, out);
  const std::size_t step = kChunk / (source.stride * source.sample_size) * source.sample_size;
  std::vector<std::byte> stored(std::min(step, out.size()) * source.stride);
  for (std::size_t at = 0; at < out.size(); at += step) {
    const auto part = out.subspan(at, std::min(step, out.size() - at));
    TRY(take(at, std::span(stored).first(part.size() * source.stride)));
    pick_samples(stored.data(), part, source);
  }
  return {};
}

// Reads wanted bytes of a piece from `first` on, and converts them to native byte order while they are in the cache.
// Calls leave(part) for each part of `out` that is complete.
template <class Leave>
Result<void> read_range(const files::InputFile& file, const SamplePiece& piece, std::uint64_t first,
                        std::span<std::byte> out, const SampleSource& source, const Context& context,
                        const Leave& leave) {
  return for_each_parallel((out.size() + kChunk - 1) / kChunk, [&](std::size_t i) -> Result<void> {
    TRY(context.check());
    const auto chunk = out.subspan(i * kChunk, std::min(kChunk, out.size() - i * kChunk));
    auto read = fill_from_lane(chunk, source, [&](std::size_t at, std::span<std::byte> bytes) {
      return file.read_at(piece.offset + (first + i * kChunk + at) * source.stride, bytes);
    });
    if (!read) return read;
    if (source.swap_bytes) swap_samples(chunk, source.sample_size);
    leave(chunk);
    context.progress().advance(chunk.size());
    return {};
  });
}

std::string_view packing_of(const SamplePiece& piece) { return piece.deflated ? "packed" : "gzip"; }

// Reads the wanted samples of a compressed piece sequentially, in native byte order.
class PackedSamples {
 public:
  // `wanted` is the total number of bytes that will be read.
  static Result<PackedSamples> open(const files::InputFile& file, const SamplePiece& piece, const SampleSource& source,
                                    std::uint64_t wanted) {
    PackedSamples samples(file, source, packing_of(piece),
                          checked_sum(piece.skip, wanted * source.stride).value_or(~std::uint64_t{0}));
    if (piece.deflated) {
      DeflateStream stream(file, piece.offset, *piece.deflated);
      samples.stream_.emplace<DeflateStream>(std::move(stream));
    } else {
      auto stream = TRY(files::GzipStream::open(file, piece.offset));
      samples.stream_.emplace<files::GzipStream>(std::move(stream));
    }
    TRY(samples.skip(piece.skip));
    return samples;
  }

  // Calls leave(part) for each part of `out` that is complete.
  template <class Leave>
  Result<void> fill(std::span<std::byte> out, const Context& context, const Leave& leave) {
    for (std::size_t at = 0; at < out.size();) {
      TRY(context.check());
      const auto chunk = out.subspan(at, std::min(kChunk, out.size() - at));
      auto filled =
          fill_from_lane(chunk, source_, [&](std::size_t, std::span<std::byte> bytes) { return take(bytes); });
      if (!filled) return filled;
      at += chunk.size();
      if (source_.swap_bytes) swap_samples(chunk, source_.sample_size);
      leave(chunk);
      context.progress().advance(chunk.size());
    }
    return {};
  }

  // Returns whether content follows. Reads one byte further, so that the checksum at the end is verified.
  Result<bool> more() {
    std::byte next{};
    const auto got = TRY(inflate(std::span(&next, 1)));
    return got > 0;
  }

 private:
  PackedSamples(const files::InputFile& file, const SampleSource& source, std::string_view word, std::uint64_t expected)
      : file_(file), source_(source), word_(word), expected_(expected) {}

  Result<std::size_t> inflate(std::span<std::byte> out) {
    if (auto* gzip = std::get_if<files::GzipStream>(&stream_)) return gzip->inflate(out);
    return std::get<DeflateStream>(stream_).inflate(out);
  }

  Result<void> take(std::span<std::byte> bytes) {
    const auto got = TRY(inflate(bytes));
    at_ += got;
    if (got == bytes.size()) return {};
    return fail(ErrorCode::input,
                fmt::format("{}: the {} data holds {} bytes, expected {}", file_.name(), word_, at_, expected_));
  }

  Result<void> skip(std::uint64_t bytes) {
    std::vector<std::byte> skipped(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, kChunk)));
    while (at_ < bytes) {
      const std::size_t want = static_cast<std::size_t>(std::min<std::uint64_t>(bytes - at_, skipped.size()));
      TRY(take(std::span(skipped).first(want)));
    }
    return {};
  }

  const files::InputFile& file_;
  const SampleSource& source_;
  std::string_view word_;
  std::uint64_t expected_;
  std::uint64_t at_ = 0;
  std::variant<std::monostate, files::GzipStream, DeflateStream> stream_;
};

// Fails if the compressed piece cannot hold the expected bytes, as far as that is known before decompression.
Result<void> check_packed(const files::InputFile& file, const SamplePiece& piece, std::uint64_t expected,
                          const std::string& of_what) {
  const std::uint64_t found =
      piece.deflated ? piece.deflated->packed : file.size() - std::min(file.size(), piece.offset);
  const auto inflated = checked_sum(expected, piece.skip);
  if (!inflated || *inflated / files::kMaxDeflateRatio > found) {
    return fail(ErrorCode::input, fmt::format("{}: {} bytes of {} data cannot decompress to {} bytes ({})", file.name(),
                                              found, packing_of(piece), inflated.value_or(expected), of_what));
  }
  if (piece.deflated && *inflated > piece.deflated->inflated) {
    return fail(
        ErrorCode::input,
        fmt::format("{}: expected {} bytes ({}) from byte {} of the packed data on, found {}", file.name(), expected,
                    of_what, piece.skip, piece.deflated->inflated - std::min(piece.deflated->inflated, piece.skip)));
  }
  return {};
}

}  // namespace

Result<SampleSource> part_of(const SampleSource& all, const Share& lane, const Share& run) {
  const std::string name = all.pieces.front().path.string();
  SampleSource one = all;
  one.bytes = all.bytes / run.count / lane.count;
  if (lane.count > kChunk / all.sample_size) {
    return fail(ErrorCode::input, fmt::format("{}: expected at most {} interleaved volumes or components, found "
                                              "{}",
                                              name, kChunk / all.sample_size, lane.count));
  }
  one.stride = lane.count;
  one.lane = lane.index;
  if (run.count == 1) return one;
  const std::uint64_t pieces = all.pieces.size();
  if (pieces % run.count == 0) {
    const auto first = all.pieces.begin() + static_cast<std::ptrdiff_t>(run.index * (pieces / run.count));
    one.pieces.assign(first, first + static_cast<std::ptrdiff_t>(pieces / run.count));
    return one;
  }
  if (run.count % pieces != 0) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected equally many volumes in each data file, found {} volumes in {} files", name,
                            run.count, pieces));
  }
  const std::uint64_t in_piece = run.count / pieces;
  SamplePiece piece = all.pieces[static_cast<std::size_t>(run.index / in_piece)];
  (piece.packed() ? piece.skip : piece.offset) += run.index % in_piece * one.bytes * one.stride;
  one.pieces = {std::move(piece)};
  return one;
}

Result<std::uint64_t> check_source(const SampleSource& source, const std::string& what, const Context& context) {
  const std::uint64_t expected = source.piece_bytes();
  std::uint64_t extra = 0;
  for (const SamplePiece& piece : source.pieces) {
    const auto file = TRY(files::InputFile::open(piece.path, context));
    const std::uint64_t end = std::min(file.size(), piece.end.value_or(file.size()));
    const std::uint64_t found = end - std::min(end, piece.offset);
    const std::string of_what =
        source.pieces.size() == 1 ? what : fmt::format("one of {} parts of {}", source.pieces.size(), what);
    if (piece.packed()) {
      TRY(check_packed(file, piece, expected, of_what));
      if (piece.deflated) extra += piece.deflated->inflated - piece.skip - expected;
    } else if (found < expected) {
      return fail(ErrorCode::input, fmt::format("{}: expected {} bytes ({}) from byte {} on, found {}", file.name(),
                                                expected, of_what, piece.offset, found));
    } else {
      extra += found - expected;
    }
  }
  return extra;
}

bool is_mappable(const SampleSource& source) {
  const SamplePiece& piece = source.pieces.front();
  return source.pieces.size() == 1 && !piece.packed() && !source.swap_bytes && source.stride == 1 &&
         piece.offset % source.sample_size == 0;
}

std::optional<files::MappedFile> map_samples(const SampleSource& source, const Context& context) {
  if (!is_mappable(source)) return std::nullopt;
  const SamplePiece& piece = source.pieces.front();
  const auto file = files::InputFile::open(piece.path, context);
  if (!file) return std::nullopt;
  auto mapped = files::MappedFile::map(*file, piece.offset, source.bytes);
  if (!mapped) return std::nullopt;
  context.progress().begin("reading", source.bytes);
  context.progress().advance(source.bytes);
  return mapped;
}

Result<bool> read_samples(const SampleSource& source, SampleStore& store, const Context& context) {
  context.progress().begin("reading", source.bytes);
  bool has_trailing_data = false;
  const auto leave = [&](std::span<const std::byte> part) { store.leave(part); };
  const auto piece_bytes = static_cast<std::size_t>(source.piece_bytes());
  for (std::size_t i = 0; i < source.pieces.size(); ++i) {
    const SamplePiece& piece = source.pieces[i];
    const auto out = store.bytes().subspan(i * piece_bytes, piece_bytes);
    const auto file = TRY(files::InputFile::open(piece.path, context));
    if (piece.packed()) {
      auto packed = TRY(PackedSamples::open(file, piece, source, out.size()));
      TRY(packed.fill(out, context, leave));
      const auto more = TRY(packed.more());
      has_trailing_data |= more;
    } else {
      TRY(read_range(file, piece, 0, out, source, context, leave));
    }
  }
  return has_trailing_data;
}

namespace {

// Planes in x that are transposed together: long enough runs in the result, little additional memory.
constexpr int kSlab = 16;

const auto leave_nothing = [](std::span<const std::byte> /*part*/) {};

// Leaves each layer of the store, for which the reads from the slab are in the order of z: 64 layers at a time.
template <class T>
void transpose_slab(const T* slab, const glm::ivec3& dims, int x_begin, int x_count, SampleStore& store) {
  T* const out = reinterpret_cast<T*>(store.bytes().data());
  const auto nx = static_cast<std::size_t>(dims.x);
  const auto ny = static_cast<std::size_t>(dims.y);
  const auto nz = static_cast<std::size_t>(dims.z);
  const std::size_t layers = store.is_in_file() ? 64 : nz;
  for (std::size_t z_begin = 0; z_begin < nz; z_begin += layers) {
    const std::size_t z_end = std::min(z_begin + layers, nz);
    for_each_index(ny, [&](std::size_t y) {
      for (std::size_t z = z_begin; z < z_end; ++z) {
        T* row = out + (z * ny + y) * nx + static_cast<std::size_t>(x_begin);
        for (int x = 0; x < x_count; ++x) row[x] = slab[(static_cast<std::size_t>(x) * ny + y) * nz + z];
      }
    });
    store.leave(std::as_bytes(std::span(out + z_begin * ny * nx, (z_end - z_begin) * ny * nx)));
  }
}

}  // namespace

Result<bool> read_samples_transposed(const SampleSource& source, const glm::ivec3& dims, SampleStore& store,
                                     const Context& context) {
  context.progress().begin("reading", source.bytes);
  const std::uint64_t plane_bytes =
      static_cast<std::uint64_t>(dims.y) * static_cast<std::uint64_t>(dims.z) * source.sample_size;
  const int planes = store.is_in_file() ? layers_at_once(plane_bytes, dims.x, context) : std::min(kSlab, dims.x);
  const SamplePiece& piece = source.pieces.front();
  auto slab = TRY(
      make_reserved_buffer<std::byte>(static_cast<std::size_t>(plane_bytes) * static_cast<std::size_t>(planes), context,
                                      fmt::format("{}: {} planes of samples", files::input_label(piece.path), planes)));
  const auto file = TRY(files::InputFile::open(piece.path, context));
  std::optional<PackedSamples> packed;
  if (piece.packed()) {
    auto opened = TRY(PackedSamples::open(file, piece, source, source.bytes));
    packed.emplace(std::move(opened));
  }

  for (int x = 0; x < dims.x; x += planes) {
    const int count = std::min(planes, dims.x - x);
    const auto part =
        slab->values.span().first(static_cast<std::size_t>(plane_bytes) * static_cast<std::size_t>(count));
    const std::uint64_t first = plane_bytes * static_cast<std::uint64_t>(x);
    TRY(packed ? packed->fill(part, context, leave_nothing)
               : read_range(file, piece, first, part, source, context, leave_nothing));
    const auto turn = [&]<class T>(std::type_identity<T>) {
      transpose_slab(reinterpret_cast<const T*>(part.data()), dims, x, count, store);
    };
    switch (source.sample_size) {
      case 1: turn(std::type_identity<std::uint8_t>{}); break;
      case 2: turn(std::type_identity<std::uint16_t>{}); break;
      case 4: turn(std::type_identity<std::uint32_t>{}); break;
      default: turn(std::type_identity<std::uint64_t>{}); break;
    }
  }
  return packed ? packed->more() : Result<bool>(false);
}

}  // namespace isoextract::volume_io
