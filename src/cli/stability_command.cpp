// `isoextract stability`: extracts extreme fields with every method and backend, and checks every vertex.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "accuracy/extraction_comparison.hpp"
#include "base/byte_size.hpp"
#include "base/counted.hpp"
#include "base/machine.hpp"
#include "base/nearest_name.hpp"
#include "base/stopwatch.hpp"
#include "base/version.hpp"
#include "bench/stability.hpp"
#include "cli/backends.hpp"
#include "cli/command.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"
#include "cli/threads.hpp"
#include "cli/water_report.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

constexpr std::string_view kWaterCases = "water";  // selects all water cases, which have their own table

// Opens the backends given by option; by default the CPU, and a GPU if there is one.
Result<std::vector<bench::BenchBackend>> choose_backends(const StabilityFlags& flags, const Messages& messages) {
  if (flags.backends) return open_backends(plan_backends(*flags.backends, flags.device));
  std::vector<bench::BenchBackend> backends{{"cpu", extract::make_cpu_extractor(), {}}};
  auto gpu = convert::open_backend(convert::Backend::gpu, {plan_gpu(flags.device)});
  if (gpu) {
    backends.push_back({"gpu", std::move(gpu->extractor), {}});
  } else {
    messages.note({NoteId::backend, fmt::format("stability tests no GPU, because {}", gpu.error().message)});
  }
  return backends;
}

Result<std::vector<const bench::StabilityCase*>> chosen_cases(const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const bench::StabilityCase& test : bench::stability_cases()) known.emplace_back(test.name);
  known.emplace_back(kWaterCases);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    const std::string near = nearest_name(name, known);
    return fail(
        ErrorCode::usage, fmt::format("--case: there is no case '{}'", name),
        near.empty() ? "'isoextract stability --list' lists the cases" : fmt::format("did you mean '{}'?", near));
  }
  std::vector<const bench::StabilityCase*> chosen;
  for (const bench::StabilityCase& test : bench::stability_cases()) {
    if (names.empty() || std::find(names.begin(), names.end(), test.name) != names.end()) chosen.push_back(&test);
  }
  return chosen;
}

bool wants_water(const std::vector<std::string>& names) {
  return names.empty() || std::ranges::find(names, kWaterCases) != names.end();
}

// Returns a description of all water cases.
std::string water_extremes() {
  std::vector<std::string> texts;
  for (const simulate::WaterStabilityScene& scene : simulate::water_stability_scenes()) {
    texts.push_back(fmt::format("{}: {}", scene.name, scene.extreme));
  }
  return fmt::format("Simulated, friction 0 and 1, flow-div 1 to 4. {}", fmt::join(texts, " "));
}

std::string list_text(const std::vector<const bench::StabilityCase*>& cases, bool water) {
  std::string text;
  for (const bench::StabilityCase* test : cases) {
    text += fmt::format("{}\n  {}\n  Plain float32: {}.\n", test->name, test->extreme, test->plain);
  }
  if (water) text += fmt::format("{}\n  {}\n", kWaterCases, water_extremes());
  return text;
}

convert::Json list_json(const std::vector<const bench::StabilityCase*>& cases, bool water) {
  convert::Json json = convert::Json::array();
  for (const bench::StabilityCase* test : cases) {
    json.push_back({{"schema", word_of(convert::JsonDocument::stability_cases)},
                    {"case", test->name},
                    {"extreme", test->extreme},
                    {"plain_float32", test->plain},
                    {"plain_float32_fails", test->float32_fails}});
  }
  if (water) {
    json.push_back({{"schema", word_of(convert::JsonDocument::stability_cases)},
                    {"case", kWaterCases},
                    {"extreme", water_extremes()}});
  }
  return json;
}

std::size_t count_failed(const std::vector<bench::StabilityRow>& rows) {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [](const bench::StabilityRow& row) { return !row.failures.empty(); }));
}

// Returns each reason of all rows once.
std::vector<std::string> not_applicable(const std::vector<bench::StabilityRow>& rows) {
  std::vector<std::string> reasons;
  for (const bench::StabilityRow& row : rows) {
    for (const std::string& reason : row.not_applicable) {
      if (std::ranges::find(reasons, reason) == reasons.end()) reasons.push_back(reason);
    }
  }
  return reasons;
}

// Returns a line per method in the rows with its checks, in the order of the methods: "marching cubes: finite vertices,
// ...".
std::vector<std::string> checked_methods(const std::vector<bench::StabilityRow>& rows) {
  std::vector<std::string> lines;
  for (const extract::MethodInfo& method : extract::kMethods) {
    if (std::ranges::find(rows, method.method, &bench::StabilityRow::method) == rows.end()) continue;
    const bench::StabilityFindings checked = bench::empty_findings(method.traits);
    std::string line = fmt::format("{}: finite vertices", method.title);
    if (checked.edges_checked) line += ", each inside its own grid edge";
    if (checked.crossings_checked) line += " and at its crossing";
    line += fmt::format("; triangles with an area, none repeated; manifold, oriented, closed {}",
                        method.traits.always_closed ? "everywhere" : "with a cap");
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string table_text(const std::vector<bench::StabilityRow>& rows) {
  std::string text = fmt::format("{:<18} {:<12} {:<10} {:>8} {:>9} {:>6} {:>8} {:>8}  {}\n", "case", "method",
                                 "backend", "vertices", "triangles", "ulps", "voxels", "allowed", "verdict");
  for (const bench::StabilityRow& row : rows) {
    const bench::StabilityFindings& found = row.findings;
    const auto crossing = [&](std::string number) { return found.crossings_checked ? std::move(number) : "-"; };
    text +=
        fmt::format("{:<18} {:<12} {:<10} {:>8} {:>9} {:>6} {:>8} {:>8}  {}\n", row.name, word_of(row.method),
                    row.backend, found.vertices, found.triangles, crossing(fmt::format("{:.2f}", found.ulps)),
                    crossing(fmt::format("{:.1e}", found.voxels)), crossing(fmt::format("{:.1e}", row.voxels_allowed)),
                    row.failures.empty() ? "pass" : fmt::format("FAIL: {}", fmt::join(row.failures, "; ")));
  }
  for (const std::string& line : checked_methods(rows)) text += fmt::format("Checked of {}\n", line);
  for (const std::string& reason : not_applicable(rows)) text += fmt::format("Not applicable: {}\n", reason);
  return text + fmt::format("{} of {} passed\n", rows.size() - count_failed(rows), rows.size());
}

convert::Json row_json(const bench::StabilityRow& row) {
  const bench::StabilityFindings& found = row.findings;
  const auto where = [](bool checked, const auto& value) { return checked ? convert::Json(value) : convert::Json(); };
  convert::Json json{{"case", row.name},
                     {"method", word_of(row.method)},
                     {"backend", row.backend},
                     {"passed", row.failures.empty()},
                     {"failures", row.failures},
                     {"vertices", found.vertices},
                     {"triangles", found.triangles},
                     {"not_finite", found.not_finite},
                     {"off_edge", where(found.edges_checked, found.off_edge)},
                     {"repeated", found.repeated},
                     {"zero_area", found.zero_area},
                     {"open_edges", found.open_edges},
                     {"unsound", found.unsound},
                     {"ulps", where(found.crossings_checked, found.ulps)},
                     {"ulps_allowed", where(found.crossings_checked, accuracy::kStabilityUlps)},
                     {"voxels", where(found.crossings_checked, found.voxels)},
                     {"voxels_allowed", where(found.crossings_checked, row.voxels_allowed)}};
  if (!row.not_applicable.empty()) json["not_applicable"] = row.not_applicable;
  return json;
}

// Extracts the cases with every method on every backend.
Result<std::vector<bench::StabilityRow>> extracted_rows(const std::vector<const bench::StabilityCase*>& cases,
                                                        const StabilityFlags& flags, const Messages& messages) {
  const auto backends = TRY(choose_backends(flags, messages));
  const std::span<const extract::MethodInfo> methods = extract::kMethods;
  for (const std::string& missing : bench::missing_methods(backends, methods))
    messages.note({NoteId::backend, missing});
  std::vector<bench::StabilityRow> rows;
  for (const bench::StabilityCase* test : cases) {
    for (const extract::MethodInfo& method : methods) {
      for (const bench::BenchBackend& backend : backends) {
        if (!backend.runs(method.method)) continue;
        rows.push_back(bench::run_stability_case(*test, method, *backend.extractor, Context()));
        rows.back().backend = backend.name;
      }
    }
  }
  return rows;
}

// Prints the table, the JSON or the list of cases. Fails with ErrorCode::usage for an unknown case, and with
// ErrorCode::verification, after the table, if a case fails.
Result<void> run_stability(const StabilityFlags& flags, const Messages& messages) {
  const auto cases = TRY(chosen_cases(flags.cases));
  const bool water = wants_water(flags.cases);
  if (flags.list) {
    return print_to_stdout(flags.json ? convert::json_text(list_json(cases, water)) : list_text(cases, water));
  }
  std::vector<bench::StabilityRow> rows;
  if (!cases.empty()) {
    const Stopwatch watch;
    rows = TRY(extracted_rows(cases, flags, messages));
    messages.detail(fmt::format("{} extracted and checked in {:.2f} s", counted(rows.size(), "surface"),
                                watch.elapsed().wall_seconds));
  }
  std::vector<simulate::WaterStabilityRow> water_rows;
  if (water) {
    const Stopwatch watch;
    water_rows = TRY(simulate::run_water_stability(simulate::kStabilitySteps, Context()));
    messages.detail(
        fmt::format("{} water cases simulated in {:.2f} s", water_rows.size(), watch.elapsed().wall_seconds));
  }
  messages.detail(fmt::format("peak memory {}", format_byte_size(peak_memory())));
  const std::size_t failed = count_failed(rows) + cli::count_failed(water_rows);
  convert::Json json{
      {"schema", word_of(convert::JsonDocument::stability)}, {"version", version()}, {"passed", failed == 0}};
  json["rows"] = convert::Json::array();
  for (const bench::StabilityRow& row : rows) json["rows"].push_back(row_json(row));
  if (water) json["water"] = water_json(water_rows);
  std::string text = rows.empty() ? "" : table_text(rows);
  if (water) text += (text.empty() ? "" : "\n") + water_table(water_rows);
  TRY(print_to_stdout(flags.json ? convert::json_text(json) : text));
  if (failed == 0) return {};
  return fail(ErrorCode::verification, fmt::format("{} of {} cases failed", failed, rows.size() + water_rows.size()),
              "please report the verdicts of the failed cases");
}

class StabilityCommand final : public CommandOf<StabilityFlags> {
 public:
  StabilityCommand() : CommandOf({"stability", "[options]", "Extract extreme fields and check every vertex."}) {}

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    const MessageChoice shown = TRY(plan_messages(flags().run));
    TRY(limit_threads(flags().run.threads));
    TRY(run_stability(flags(), Messages(shown)));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_stability_command() { return std::make_unique<StabilityCommand>(); }

}  // namespace isoextract::cli
