#include "cli/check_options.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/plan_parts.hpp"
#include "cli/shared_options.hpp"
#include "convert/output_checks.hpp"

namespace isoextract::cli {
namespace {

using measure::Requirement;

constexpr std::string_view kPrintable = "printable";
constexpr std::array kOfPrintable{Requirement::closed,
                                  Requirement::manifold,
                                  Requirement::oriented,
                                  Requirement::outward,
                                  Requirement::no_self_intersections,
                                  Requirement::no_zero_area,
                                  Requirement::no_duplicates};

std::vector<std::string> requirement_words() {
  std::vector<std::string> words;
  for (const Word<Requirement>& entry : words_of(Requirement{})) words.emplace_back(entry.word);
  return words;
}

}  // namespace

void declare_check(CLI::App& app, CheckFlags& flags) {
  const Group input(app, "Input");
  input.values<std::string>(
      "FILE", "FILE", flags.meshes, parse_text,
      "The mesh: .glb, .gltf, .ply, .obj, .stl or .drc, or - for stdin. Corners without connectivity, as in stl, are "
      "welded where their coordinates are equal. Of a glTF file with several meshes each is checked, and then all of "
      "them as one.");
  input.flag("--weld", flags.weld,
             "Join vertices with the same coordinates first, as slicers do. Without it they are told apart, and the "
             "report says what joining them would close.");
  input.value("--memory-limit", "SIZE", flags.memory_limit, parse_size, kMemoryLimitText);
  const Group output(app, "Output");
  output.value("--require", "WORD,WORD,...", flags.required, parse_requirements,
               fmt::format("Exit with code 6 unless the mesh is all of these: {}; or {}, which is {}.",
                           fmt::join(requirement_words(), ", "), kPrintable, [] {
                             std::vector<std::string_view> words;
                             for (const Requirement one : kOfPrintable) words.push_back(word_of(one));
                             return fmt::format("{}", fmt::join(words, ", "));
                           }()));
  output.flag("--json", flags.json, "Report as JSON.");
  output.value<std::string>("--report", "FILE", flags.report, parse_text, "Write the same JSON into a file as well.");
  declare_run(app, flags.run);
}

Result<std::vector<Requirement>> parse_requirements(std::string_view text) {
  std::vector<Requirement> required;
  const auto add = [&](Requirement one) {
    if (std::ranges::find(required, one) == required.end()) required.push_back(one);
  };
  std::vector<std::string> words = requirement_words();
  words.emplace_back(kPrintable);
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string_view word = text.substr(at, end - at);
    at = end + 1;
    if (const auto one = value_of<Requirement>(word)) {
      add(*one);
    } else if (word == kPrintable) {
      for (const Requirement part : kOfPrintable) add(part);
    } else {
      const std::string near = nearest_name(word, words);
      return fail(ErrorKind::usage, fmt::format("expected some of {}, found '{}'", fmt::join(words, ", "), word),
                  near.empty() ? "" : fmt::format("did you mean '{}'?", near));
    }
  }
  return required;
}

Result<CheckPlan> plan_check(const CheckFlags& flags) {
  if (flags.meshes.size() != 1) {
    return refuse_usage(fmt::format("check takes one mesh, found {}{}{}", flags.meshes.size(),
                                    flags.meshes.empty() ? "" : ": ", fmt::join(flags.meshes, ", ")),
                        "isoextract check MESH");
  }
  if (flags.report) {
    files::ReadFiles read;
    convert::add_read_mesh(read, flags.meshes.front(), Context(plan_memory(flags.memory_limit)));
    if (auto checked = convert::check_output_file(*flags.report, read); !checked) {
      if (checked.error().kind == ErrorKind::usage) checked.error().hint = "choose another name with --report";
      return tl::unexpected(checked.error());
    }
  }
  CheckPlan plan;
  plan.mesh = flags.meshes.front();
  plan.weld = flags.weld;
  plan.required = flags.required.value_or(std::vector<Requirement>());
  plan.report = flags.report;
  plan.memory = plan_memory(flags.memory_limit);
  plan.json = flags.json;
  return plan;
}

}  // namespace isoextract::cli
