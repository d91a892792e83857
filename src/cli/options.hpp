// The command line as CLI11 parses it: the commands, and the flags that their options are members of (options/). Help,
// man page and completions are made from it, too.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/generate_docs.hpp"
#include "cli/option.hpp"
#include "cli/options/convert.hpp"
#include "cli/options/measuring.hpp"
#include "cli/options/meshes.hpp"
#include "cli/options/render.hpp"
#include "cli/options/simulate.hpp"

namespace isoextract::cli {

struct MergeFlags : OptionSet {
  Value<std::string> folder{in(OptionGroup::input), "FOLDER", "FOLDER", parse_text,
                            "The folder of the outputs, where the manifests of the shards are."};
  RunFlags run{*this, RunFlags::Taken::quiet};
};

struct DevicesFlags : OptionSet {
  JsonFlag json{in(OptionGroup::output), "Report as JSON, an array with one entry a device."};
  RunFlags run{*this, RunFlags::Taken::quiet};  // says nothing but its results anyway
};

struct SimulateFlags : OptionSet {
  RunFlags run{*this, RunFlags::Taken::help};
};

// Every word that `help` takes.
[[nodiscard]] std::vector<Choice<std::string>> help_topic_choices();

struct HelpFlags : OptionSet {
  Value<std::string> topic{in(OptionGroup::input), "TOPIC", help_topic_choices(),
                           "A command, a group of options, or a subject."};
  RunFlags run{*this, RunFlags::Taken::quiet};
};

struct GenerateFlags : OptionSet {
  Value<Document> document{in(OptionGroup::input), "DOCUMENT", "The man page, or the completion script of a shell."};
  RunFlags run{*this, RunFlags::Taken::quiet};
};

struct CommandLine {
  CLI::App app;
  CLI::App* convert = nullptr;
  CLI::App* info = nullptr;
  CLI::App* verify = nullptr;
  CLI::App* compare = nullptr;
  CLI::App* check = nullptr;
  CLI::App* render = nullptr;
  CLI::App* bench = nullptr;
  CLI::App* stability = nullptr;
  CLI::App* devices = nullptr;
  CLI::App* merge = nullptr;
  CLI::App* simulate = nullptr;  // its sub-commands say what
  CLI::App* simulate_water = nullptr;
  CLI::App* simulate_jet = nullptr;
  CLI::App* help = nullptr;
  CLI::App* generate = nullptr;

  ConvertFlags convert_flags;
  InfoFlags info_flags;
  VerifyFlags verify_flags;
  CompareFlags compare_flags;
  CheckFlags check_flags;
  RenderFlags render_flags;
  BenchFlags bench_flags;
  StabilityFlags stability_flags;
  DevicesFlags devices_flags;
  MergeFlags merge_flags;
  SimulateFlags simulate_flags;
  WaterFlags water_flags;
  JetFlags jet_flags;
  HelpFlags help_flags;
  GenerateFlags generate_flags;
};

[[nodiscard]] std::unique_ptr<CommandLine> declare_command_line();

// Thrown through CLI11, and caught where the parser is called: a value that its option does not take.
struct BadValue : CLI::ParseError {
  explicit BadValue(isoextract::Error why)
      : CLI::ParseError(why.message, CLI::ExitCodes::ValidationError), error(std::move(why)) {}
  isoextract::Error error;
};

// What the documents ask of the declarations.
[[nodiscard]] std::string synopsis(const CLI::App& command);                // "isoextract info INPUT... [options]"
[[nodiscard]] std::string spelling(const CLI::Option& option);              // "-o, --output FILE"
[[nodiscard]] std::vector<std::string> choices(const CLI::Option& option);  // empty if it takes any value
[[nodiscard]] bool takes_value(const CLI::Option& option);
[[nodiscard]] bool value_is_optional(const CLI::Option& option);  // without one the first choice is meant
[[nodiscard]] std::vector<const CLI::Option*> options_in_group(const CLI::App& command, const std::string& group);
// The commands of the program, or the sub-commands of a command: "water" of "simulate".
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& app);
// The commands of the program, each followed by its sub-commands.
[[nodiscard]] std::vector<const CLI::App*> all_commands(const CLI::App& app);
// As it is written after the program's name: "simulate water".
[[nodiscard]] std::string full_name(const CLI::App& command);

}  // namespace isoextract::cli
