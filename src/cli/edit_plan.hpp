// The options that change fields and surfaces, as values of a job.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

// Of a job whose other options are planned.
[[nodiscard]] Result<void> plan_edits(const ConvertFlags& flags, convert::ConversionJob& job);

// Whether pieces can go where -o says; `path` is what it says.
[[nodiscard]] Result<void> check_piece_outputs(const ConvertFlags& flags, const std::string& path,
                                               const mesh_io::MeshFormatInfo& format);
}  // namespace isoextract::cli
