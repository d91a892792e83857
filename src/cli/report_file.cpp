#include "cli/report_file.hpp"

#include <utility>

#include "cli/remedies.hpp"
#include "convert/json_values.hpp"
#include "convert/output_checks.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {

Result<void> check_report_file(const std::string& path, const convert::ConversionJob& job, const Context& context) {
  auto checked = convert::check_extra_output(path, job, context);
  if (!checked && checked.error().code == ErrorCode::usage) checked.error().hint = "choose another name with --report";
  return checked;
}

Result<void> write_report(const std::string& path, const convert::ConversionJob* job, const convert::Outcome& outcome,
                          const Notes& notes, const std::vector<std::string>& arguments, std::uint64_t memory_limit) {
  const std::string hint = outcome.error ? hint_text(outcome.error->hint) : "";
  convert::Json report = convert::report_of(job, outcome, arguments, memory_limit, hint);
  Notes all = notes;
  all.insert(all.end(), outcome.notes.begin(), outcome.notes.end());
  report["notes"] = convert::json_of_notes(all);
  return files::write_file(path, convert::json_text(report));
}

}  // namespace isoextract::cli
