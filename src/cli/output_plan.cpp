#include "cli/output_plan.hpp"

#include <fmt/format.h>

#include "base/printable.hpp"
#include "cli/edit_plan.hpp"
#include "cli/picture_plan.hpp"
#include "cli/plan_parts.hpp"
#include "convert/particle_source.hpp"

namespace isoextract::cli {

Result<std::vector<batch::OutputFiles>> plan_outputs(const ConvertFlags& flags,
                                                     std::span<const batch::OutputSource> sources,
                                                     mesh_io::MeshFormat format, const batch::OtherFiles& others) {
  TRY(check_piece_outputs(flags, flags.output.value_or(""), mesh_io::mesh_format_info(format)));
  return batch::name_outputs(sources, flags.output, format, non_mesh_extension(flags), others);
}

Result<batch::OutputTemplate> plan_report_name(const std::string& report) {
  auto name = batch::OutputTemplate::parse(report);
  if (name && name->uses(batch::OutputWord::piece)) {
    return refuse_usage(fmt::format("--report {}: a report covers a whole frame, not one body", report),
                        "leave {piece} out of the file name");
  }
  if (name && (name->uses(batch::OutputWord::label) || name->uses(batch::OutputWord::name))) {
    return refuse_usage(fmt::format("--report {}: a report covers a whole frame, not one label", report),
                        "leave {label} and {name} out of the file name");
  }
  return name;
}

std::string report_path(const batch::OutputTemplate& name, const batch::OutputSource& source) {
  return name.expand({batch::stem_of(source.input), source.frame, source.grid,
                      source.isos.empty() ? "" : file_name_part(source.isos.front()), source.step.value_or(0)});
}

Result<void> find_steps(const ConvertFlags& flags, const convert::SourceOptions& read, const Context& context,
                        std::span<batch::OutputSource> sources) {
  const auto uses_step = [](const Value<std::string>& name) {
    const auto parsed = name ? batch::OutputTemplate::parse(*name) : Result<batch::OutputTemplate>();
    return parsed && parsed->uses(batch::OutputWord::step);
  };
  const bool in_report = uses_step(flags.report);
  if (!in_report && !uses_step(flags.output)) return {};
  for (batch::OutputSource& source : sources) {
    if (!source.step) {
      convert::SourceOptions one = read;
      one.input = source.input;
      source.step = TRY(convert::find_frame_time(one, context.beside())).step;
    }
    if (in_report && !source.step) {
      return refuse_usage(fmt::format("--report {}: expected the number of a time step for {{step}}, found none in {}",
                                      *flags.report, printable(source.input)),
                          "put {frame} into the name instead");
    }
  }
  return {};
}

batch::OtherFiles other_files(const ConvertFlags& flags, std::span<const batch::OutputSource> sources,
                              const std::optional<batch::OutputTemplate>& report) {
  batch::OtherFiles others;
  const auto reads = [&](const std::optional<std::string>& path, const char* what) {
    if (path) others.read.push_back({*path, what, {}});
  };
  const auto writes = [&](const Option& option, const std::string& path, const std::string& what) {
    others.written.push_back({path, what, fmt::format("choose another name with {}", option.name())});
  };
  const auto may_write = [&](const Value<std::string>& option, const std::string& what) {
    if (option) writes(option, *option, what);
  };
  reads(flags.config, "has the options");
  reads(flags.batch.iso_table, "has the iso values");
  reads(flags.labels.names, "has the names of labels");
  may_write(flags.batch.table, "the table");
  may_write(flags.batch.plot, "the plot");
  may_write(flags.html, "the page");
  may_write(flags.contact_sheet, "the contact sheet");
  if (!report) return others;
  for (const batch::OutputSource& source : sources) {
    writes(flags.report, report_path(*report, source),
           source.alone ? "the report" : fmt::format("the report of frame {}", source.frame));
  }
  return others;
}

}  // namespace isoextract::cli
