// What `isoextract bench gpu-threads` found, as a table and as JSON.
#pragma once

#include <string>

#include "batch/json_values.hpp"
#include "gpu/thread_creation.hpp"

namespace isoextract {

[[nodiscard]] std::string gpu_threads_table(const ThreadCreationResult& result, int repeats);
[[nodiscard]] Json gpu_threads_json(const ThreadCreationResult& result, int repeats);

}  // namespace isoextract
