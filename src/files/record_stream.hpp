// Many small records of one kind on their way into a file: filled in parallel, written in order.
#pragma once

#include <cstddef>
#include <functional>

#include "base/error.hpp"
#include "files/output_file.hpp"

namespace isoextract::files {

// Puts records [first, last) at `out` and returns the end of what it put. Called from many threads.
using FillRecords = std::function<char*(std::size_t first, std::size_t last, char* out)>;

// Writes records [0, count). A record takes at most `max_record_bytes`. The bytes do not depend on the number of
// threads; memory is a few blocks a thread, however many records there are.
[[nodiscard]] Result<void> write_records(OutputFile& file, std::size_t count, std::size_t max_record_bytes,
                                         const FillRecords& fill);

}  // namespace isoextract::files
