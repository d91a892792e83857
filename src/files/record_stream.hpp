// Writes many small records of one kind to a file: formatted in parallel, written in order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "base/error.hpp"
#include "files/output_file.hpp"

namespace isoextract::files {

// Writes records [first, last) to `out` and returns the end of the written bytes. Called from several threads.
using FillRecords = std::function<char*(std::size_t first, std::size_t last, char* out)>;

// Writes records [0, count). `max_record_bytes` is the largest size of one record, at least 1. The bytes do not depend
// on the number of threads. Uses two blocks per thread, each of at most 1 MiB or one record. Fails as
// OutputFile::write().
[[nodiscard]] Result<void> write_records(OutputFile& file, std::size_t count, std::size_t max_record_bytes,
                                         const FillRecords& fill);

// Fills the room of `count` records of `record_bytes` bytes each, from file offset `place` on (OutputFile::extend()).
// Works on the calling thread alone; several threads may fill disjoint ranges at once. Fails as OutputFile::fill().
[[nodiscard]] Result<void> fill_records(const OutputFile& file, std::uint64_t place, std::size_t count,
                                        std::size_t record_bytes, const FillRecords& fill);

}  // namespace isoextract::files
