// Writes the results of the benchmark as Markdown and as JSON.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/rounds.hpp"

namespace isoextract::bench {

// Returns the processor, its threads, and how VTK uses them.
[[nodiscard]] std::string machine_line();

[[nodiscard]] std::string group_table(const Group& group);

// Returns, for inputs of several sizes, isoextract's time from each size to the next beside the bytes that it reads and
// writes. Empty if no input has two sizes.
[[nodiscard]] std::string growth_table(const std::vector<Group>& groups);

[[nodiscard]] nlohmann::json report_json(const std::vector<Group>& groups, int rounds);

}  // namespace isoextract::bench
