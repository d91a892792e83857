// Names the output files of a run, for one conversion and for the frames of a batch.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/output_names.hpp"
#include "batch/output_template.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::cli {

// Names the outputs of every source by -o, and checks them together with `others` (batch::name_outputs). Fails with
// ErrorCode::usage if outputs share a name, -o is empty, or {piece} does not suit --split-components
// (check_piece_outputs).
[[nodiscard]] Result<std::vector<batch::OutputFiles>> plan_outputs(const ConvertFlags& flags,
                                                                   std::span<const batch::OutputSource> sources,
                                                                   mesh_io::MeshFormat format,
                                                                   const batch::OtherFiles& others);

// Parses the value of --report. Fails with ErrorCode::usage if it is invalid or contains {piece}, {label} or {name}.
[[nodiscard]] Result<batch::OutputTemplate> plan_report_name(const std::string& report);

// Sets the step of each source that has none, if -o or --report contain {step}: reads the header of the source's frame.
// `read`: how to read the input. Fails as convert::find_frame_time() does, and with ErrorCode::usage if a
// name of --report needs a step and the file states none.
[[nodiscard]] Result<void> find_steps(const ConvertFlags& flags, const convert::SourceOptions& read,
                                      const Context& context, std::span<batch::OutputSource> sources);

// Returns the path of a source's report; {iso} stands for the source's first iso value.
[[nodiscard]] std::string report_path(const batch::OutputTemplate& name, const batch::OutputSource& source);

// Returns the files that the options name besides inputs, attribute files and -o: files to read and files to write.
// With `report`, the files to write include a report for each source.
[[nodiscard]] batch::OtherFiles other_files(const ConvertFlags& flags, std::span<const batch::OutputSource> sources,
                                            const std::optional<batch::OutputTemplate>& report);

}  // namespace isoextract::cli
