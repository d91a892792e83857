// Plans the options that change fields and surfaces.
#pragma once

#include <string>
#include <string_view>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

// Sets the edits of a job whose other options are already planned.
[[nodiscard]] Result<void> plan_edits(const ConvertFlags& flags, convert::ConversionJob& job);

// Checks that the output `path`, the value of -o, suits the components of --split-components.
[[nodiscard]] Result<void> check_piece_outputs(const ConvertFlags& flags, const std::string& path,
                                               const mesh_io::MeshFormatInfo& format);
}  // namespace isoextract::cli
