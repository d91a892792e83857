// Locates samples in files, checks their sizes, and brings them into memory: maps them if their layout fits, else reads
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "files/mapped_file.hpp"
#include "volume_io/detail/deflate_stream.hpp"
#include "volume_io/detail/sample_store.hpp"

namespace isoextract::volume_io {

// A contiguous run of samples in a file.
struct SamplePiece {
  std::filesystem::path path;
  std::uint64_t offset = 0;  // of the first sample, or of the compressed bytes
  bool gzip = false;
  std::uint64_t skip = 0;                       // compressed only: decompressed bytes before the first sample
  std::optional<DeflatedMember> deflated = {};  // compressed as a member of a ZIP file
  std::optional<std::uint64_t> end = {};        // end of its bytes in the file; default: the end of the file

  [[nodiscard]] bool packed() const { return gzip || deflated.has_value(); }
};

struct SampleSource {
  std::vector<SamplePiece> pieces;  // in sequence; all have the same number of bytes
  std::uint64_t bytes = 0;          // of all pieces
  std::size_t sample_size = 1;
  bool swap_bytes = false;  // the byte order differs from the machine's
  // For interleaved samples: of each `stride` samples in the pieces, only the one at `lane` is wanted.
  std::uint64_t stride = 1;
  std::uint64_t lane = 0;

  [[nodiscard]] std::uint64_t piece_bytes() const { return bytes / pieces.size(); }
};

// Part `index` of `count` equal parts.
struct Share {
  std::uint64_t index = 0;
  std::uint64_t count = 1;
};

// Selects a part of the samples in `all`: run run.index of run.count consecutive runs, and of these samples only number
// lane.index of each lane.count interleaved ones. Fails if the run is neither whole pieces nor part of one, or if too
// many samples are interleaved.
[[nodiscard]] Result<SampleSource> part_of(const SampleSource& all, const Share& lane, const Share& run);

// For a source without lanes: compares its sizes with the files before allocating memory, and returns the number of
// bytes after the samples. Does not count gzip contents, whose size is unknown. `what` describes the bytes in messages,
// for example "100x100x100 f32 samples".
[[nodiscard]] Result<std::uint64_t> check_source(const SampleSource& source, const std::string& what,
                                                 const Context& context);

// Returns whether the samples have the same layout in the file and in memory: one piece, not interleaved or compressed,
// native byte order, aligned offset.
[[nodiscard]] bool is_mappable(const SampleSource& source);

// Maps samples that need no conversion (is_mappable()).
// Reports their bytes as "reading" at once. Returns nothing if the layout does not fit or the system cannot map them;
// then call read_samples().
[[nodiscard]] std::optional<files::MappedFile> map_samples(const SampleSource& source, const Context& context);

// Reads all pieces into a store of their size, in native byte order. Returns whether decompressed bytes follow the
// samples. Reports bytes as "reading".
[[nodiscard]] Result<bool> read_samples(const SampleSource& source, SampleStore& store, const Context& context);

// Reads a piece whose last axis is the fastest, so that x is the fastest in the store. Reserves memory for some planes
// in x: 16, or more if the store is in a file, as each run of planes passes over the whole file. Returns the same.
[[nodiscard]] Result<bool> read_samples_transposed(const SampleSource& source, const glm::ivec3& dims,
                                                   SampleStore& store, const Context& context);

}  // namespace isoextract::volume_io
