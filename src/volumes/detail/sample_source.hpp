// Samples as they lie in files: where the bytes are, whether they fit, and how they come into memory: mapped where they
// lie there as they are wanted, read otherwise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "files/mapped_file.hpp"

namespace isoextract::volumes {

// A run of samples in a file.
struct SamplePiece {
  std::filesystem::path path;
  std::uint64_t offset = 0;  // of the first sample, or of the gzip stream
  bool gzip = false;
  std::uint64_t skip = 0;  // gzip only: inflated bytes before the first sample
};

struct SampleSource {
  std::vector<SamplePiece> pieces;  // one after the other; all hold the same number of bytes
  std::uint64_t bytes = 0;          // of all pieces
  std::size_t sample_size = 1;
  bool swap_bytes = false;  // the stored byte order is not the machine's
  // Where other samples lie between those that are wanted: of each `stride` samples in the pieces the one at `lane`.
  std::uint64_t stride = 1;
  std::uint64_t lane = 0;

  [[nodiscard]] std::uint64_t piece_bytes() const { return bytes / pieces.size(); }
};

// Volume `index` of the `count` volumes of one size that `all` holds: one after the other, or with their samples side
// by side. Fails where its samples are not whole pieces or a part of one, or too many lie side by side.
[[nodiscard]] Result<SampleSource> volume_of(const SampleSource& all, std::uint64_t index, std::uint64_t count,
                                             bool interleaved);

// For a source without lanes: holds the sizes against the files before any memory is taken, and returns how many bytes
// follow the samples (not counting what gzip holds). `what` says in messages what the bytes are, for example
// "100x100x100 f32 samples".
[[nodiscard]] Result<std::uint64_t> check_source(const SampleSource& source, const std::string& what,
                                                 const Context& context);

// Samples that lie in their file just as they are wanted: one piece, nothing between them, not gzip, native byte order,
// at an offset aligned for their type. Counts them as read once, and reports them as "reading". Nothing where they lie
// otherwise or where the system cannot map them: then they are to be read.
[[nodiscard]] std::optional<files::MappedFile> map_samples(const SampleSource& source, const Context& context);

struct ReadSamples {
  Buffer<std::byte> data;
  bool more_in_gzip = false;  // inflated bytes follow the samples
};

// Reads all pieces, straight into one buffer and in native byte order. Reports bytes as "reading". Its memory is the
// caller's to reserve.
[[nodiscard]] Result<ReadSamples> read_samples(const SampleSource& source, const Context& context);

// The same for one piece that is not gzip and whose last axis is the fastest one: the result has x fastest. Needs
// transpose_bytes() on top of the result.
[[nodiscard]] Result<ReadSamples> read_samples_transposed(const SampleSource& source, const glm::ivec3& dims,
                                                          const Context& context);
[[nodiscard]] std::uint64_t transpose_bytes(const glm::ivec3& dims, std::size_t sample_size);

}  // namespace isoextract::volumes
