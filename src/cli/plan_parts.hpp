// What the plans of several commands are made of.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

[[nodiscard]] inline tl::unexpected<Error> refuse_usage(std::string message, Hint hint = {}) {
  return fail(ErrorCode::usage, std::move(message), std::move(hint));
}

// `besides` is what else than formats of meshes is expected.
[[nodiscard]] Result<mesh_io::MeshFormat> format_of_path(const std::string& path, std::string hint,
                                                         std::string_view besides = "");

// Of a name, in small letters and with its dot; empty where there is none.
[[nodiscard]] std::string extension_of(const std::string& path);

// The format of files that is said by --format, or by the name after -o. `by_path` finds it by a name.
template <class Format, class ByPath>
[[nodiscard]] Result<Format> format_of_output(const std::optional<Format>& said, const std::string& output,
                                              const ByPath& by_path) {
  if (said) return *said;
  if (const auto format = by_path(output)) return *format;
  std::vector<std::string_view> names;
  for (const auto& entry : words_of(Format{})) names.push_back(entry.word);
  return refuse_usage(fmt::format("-o {}: expected an extension of {}", output, fmt::join(names, ", ")),
                      "or give --format");
}

// What --memory-limit says.
[[nodiscard]] MemoryBudget plan_memory(const std::optional<std::uint64_t>& limit);
[[nodiscard]] convert::SurfaceOptions plan_surface(const SurfaceFlags& flags, const InputFlags& input);
// What --roi, --roi-snap and --clip say.
[[nodiscard]] Result<void> plan_region(const SurfaceFlags& flags, convert::SourceOptions& source);
// What --resolution, --voxel-size and --kernel say.
[[nodiscard]] Result<void> plan_resolution(const SurfaceFlags& flags, convert::SourceOptions& source);
// Where no --nan is given: who says which samples are no data wants no error for them.
[[nodiscard]] extract::NanPolicy usual_nan(const InputFlags& input);
// `draws_mesh`: pages or contact sheets show the mesh with its up axis, whatever its format.
[[nodiscard]] Result<convert::Placement> plan_placement(const PlacementFlags& flags, mesh_io::MeshFormat format,
                                                        bool draws_mesh, std::vector<std::string>& notes);
// Refuses an iso value that is given twice.
[[nodiscard]] Result<void> check_isos(const std::vector<convert::IsoChoice>& isos);

}  // namespace isoextract::cli
