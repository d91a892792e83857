// Formats the results of `isoextract bench gpu-threads` as a table and as JSON.
#pragma once

#include <string>

#include "convert/json_type.hpp"
#include "gpu/thread_creation.hpp"

namespace isoextract::cli {

[[nodiscard]] std::string gpu_threads_table(const gpu::ThreadCreationResult& result, int repeats);
[[nodiscard]] convert::Json gpu_threads_json(const gpu::ThreadCreationResult& result, int repeats);

}  // namespace isoextract::cli
