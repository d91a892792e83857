// Functions that the plans of several commands share.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/options.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

[[nodiscard]] inline tl::unexpected<Error> refuse_usage(std::string message, Hint hint = {}) {
  return fail(ErrorCode::usage, std::move(message), std::move(hint));
}

// Finds the mesh format by the extension, or fails with ErrorCode::usage and `hint`. The message lists the expected
// extensions, then `besides`.
[[nodiscard]] Result<mesh_io::MeshFormat> format_of_path(const std::string& path, std::string hint,
                                                         std::string_view besides = "");

// Returns the extension in lower case with its dot; empty if there is none.
[[nodiscard]] std::string extension_of(const std::string& path);

// Returns the format of --format, or else by_path(output), the format of the extension of -o. Fails with
// ErrorCode::usage if there is neither.
template <class Format, class ByPath>
[[nodiscard]] Result<Format> format_of_output(const std::optional<Format>& said, const std::string& output,
                                              const ByPath& by_path) {
  if (said) return *said;
  if (const auto format = by_path(output)) return *format;
  std::vector<std::string_view> names;
  for (const auto& entry : words_of(Format{})) names.push_back(entry.word);
  return refuse_usage(fmt::format("-o {}: expected a name that ends in .{}", output, fmt::join(names, ", .")),
                      "or give --format");
}

// Returns the budget of --memory-limit, or else the default budget.
[[nodiscard]] MemoryBudget plan_memory(const std::optional<std::uint64_t>& limit);
[[nodiscard]] convert::SurfaceOptions plan_surface(const SurfaceFlags& flags, const InputFlags& input);
// Plans --roi, --roi-snap and --clip.
[[nodiscard]] Result<void> plan_region(const SurfaceFlags& flags, convert::SourceOptions& source);
// Plans --resolution, --voxel-size and --kernel.
[[nodiscard]] Result<void> plan_resolution(const SurfaceFlags& flags, convert::SourceOptions& source);
// Returns the default of --nan: with --nodata, NaN samples are outside instead of an error.
[[nodiscard]] extract::NanPolicy default_nan_policy(const InputFlags& input);
// Uses of a placed mesh; plan_placement() adds notes that depend on the use. A picture gets no note about the unit of a
// mesh format. With file_and_pictures, --up has an effect in every format.
enum class MeshUse { file, file_and_pictures, picture };
[[nodiscard]] Result<convert::Placement> plan_placement(const PlacementFlags& flags, mesh_io::MeshFormat format,
                                                        MeshUse use, Notes& notes);
// Refuses repeated iso values.
[[nodiscard]] Result<void> check_isos(const std::vector<convert::IsoChoice>& isos);

}  // namespace isoextract::cli
