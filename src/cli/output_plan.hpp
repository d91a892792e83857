// What the files of a run are called: one conversion and the frames of a batch alike.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/options.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

// Names the outputs of every source after -o, and checks them and `others` as one set (batch::name_outputs). Fails with
// ErrorCode::usage.
[[nodiscard]] Result<std::vector<batch::OutputFiles>> plan_outputs(const ConvertFlags& flags,
                                                                   std::span<const batch::OutputSource> sources,
                                                                   mesh_io::MeshFormat format,
                                                                   const batch::OtherFiles& others);

// Reads what --report names. Fails with ErrorCode::usage.
[[nodiscard]] Result<batch::OutputTemplate> plan_report_name(const std::string& report);

// The report of one source.
[[nodiscard]] std::string report_path(const batch::OutputTemplate& name, const batch::OutputSource& source);

// All files that the options name besides inputs and -o: those that are read, and those that are written, with a report
// for each source where `report` says its name.
[[nodiscard]] batch::OtherFiles other_files(const ConvertFlags& flags, std::span<const batch::OutputSource> sources,
                                            const std::optional<batch::OutputTemplate>& report);

}  // namespace isoextract::cli
