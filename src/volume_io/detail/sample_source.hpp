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
#include "volume_io/detail/deflate_stream.hpp"

namespace isoextract::volume_io {

// A run of samples in a file.
struct SamplePiece {
  std::filesystem::path path;
  std::uint64_t offset = 0;  // of the first sample, or of the packed bytes
  bool gzip = false;
  std::uint64_t skip = 0;                       // packed only: inflated bytes before the first sample
  std::optional<DeflatedMember> deflated = {};  // packed as a member of a ZIP file
  std::optional<std::uint64_t> end = {};        // where in the file its bytes end; else where the file does

  [[nodiscard]] bool packed() const { return gzip || deflated.has_value(); }
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

// One of `count` that lie in a certain way.
struct Share {
  std::uint64_t index = 0;
  std::uint64_t count = 1;
};

// A part of all samples that `all` holds: of the runs of samples that follow one another in it the one at `run`, and in
// that, of the samples side by side, the one at `lane`. Fails where the run is not whole pieces or a part of one, or
// too many samples lie side by side.
[[nodiscard]] Result<SampleSource> part_of(const SampleSource& all, const Share& lane, const Share& run);

// For a source without lanes: holds the sizes against the files before any memory is taken, and returns how many bytes
// follow the samples (not counting what gzip holds, whose length nothing says). `what` says in messages what the bytes
// are, for example "100x100x100 f32 samples".
[[nodiscard]] Result<std::uint64_t> check_source(const SampleSource& source, const std::string& what,
                                                 const Context& context);

// Samples that lie in their file just as they are wanted: one piece, nothing between them, not gzip, native byte order,
// at an offset aligned for their type. Counts them as read once, and reports them as "reading". Nothing where they lie
// otherwise or where the system cannot map them: then they are to be read.
[[nodiscard]] std::optional<files::MappedFile> map_samples(const SampleSource& source, const Context& context);

struct ReadSamples {
  Buffer<std::byte> data;
  bool more_packed = false;  // inflated bytes follow the samples
};

// Reads all pieces, straight into one buffer and in native byte order. Reports bytes as "reading". Its memory is the
// caller's to reserve.
[[nodiscard]] Result<ReadSamples> read_samples(const SampleSource& source, const Context& context);

// The same for one piece whose last axis is the fastest one: the result has x fastest. Needs
// transpose_bytes() on top of the result.
[[nodiscard]] Result<ReadSamples> read_samples_transposed(const SampleSource& source, const glm::ivec3& dims,
                                                          const Context& context);
[[nodiscard]] std::uint64_t transpose_bytes(const glm::ivec3& dims, std::size_t sample_size);

}  // namespace isoextract::volume_io
