#include "cli/options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/version.hpp"
#include "cli/help_topics.hpp"

namespace isoextract::cli {
namespace {

void declare_value(CLI::App& app, Option& option, const std::string& names) {
  CLI::Option* declared = app.add_option(names, CLI::callback_t([&option](const CLI::results_t& given) {
                                           for (const std::string& text : given) option.add_text(text);
                                           if (auto taken = option.take(); !taken) throw BadValue(taken.error());
                                           return true;
                                         }),
                                         option.row().help);
  declared->type_name(option.row().metavar)->group(std::string(word_of(option.row().group)));
  if (option.is_repeatable()) declared->expected(1, CLI::detail::expected_max_vector_size)->allow_extra_args(false);
  if (option.row().left_out) declared->expected(0, 1)->default_str(*option.row().left_out);
}

void declare_flag(CLI::App& app, Option& option, const std::string& names) {
  const auto set = [&option] {
    option.add_text("true");
    [[maybe_unused]] const auto taken = option.take();
  };
  app.add_flag_callback(names, set, option.row().help)
      ->disable_flag_override()
      ->group(std::string(word_of(option.row().group)));
}

void declare(CLI::App& app, OptionSet& options) {
  app.set_help_flag();  // CLI11's own, which is first
  for (Option* option : options.options()) {
    const std::string names = fmt::format("{}", fmt::join(option->row().names, ","));
    if (names == kHelpNames) {
      app.set_help_flag(names, option->row().help)->group(std::string(word_of(option->row().group)));
    } else if (option->takes_value()) {
      declare_value(app, *option, names);
    } else {
      declare_flag(app, *option, names);
    }
  }
}

CLI::App* add_command(CLI::App& app, const std::string& name, const std::string& description, OptionSet& options) {
  CLI::App* command = app.add_subcommand(name, description);
  command->allow_extras();  // the caller names what is unknown, with a suggestion
  declare(*command, options);
  return command;
}

}  // namespace

std::vector<Choice<std::string>> help_topic_choices() {
  std::vector<Choice<std::string>> topics;
  for (const std::string& name : help_names()) topics.push_back({name, name});
  return topics;
}

std::unique_ptr<CommandLine> declare_command_line() {
  auto line = std::make_unique<CommandLine>();
  CLI::App& app = line->app;
  app.name("isoextract");
  app.description("Extract isosurfaces from volumes and particles as meshes.");
  app.allow_extras();
  app.set_help_flag(std::string(kHelpNames), "Show an overview and exit.")->group("Run");
  app.set_version_flag("--version", "isoextract " + std::string(version()), "Show the version and exit.")->group("Run");
  app.require_subcommand(1);

  line->convert = add_command(app, "convert", "Extract a surface and write it as a mesh. The default command.",
                              line->convert_flags);
  line->info =
      add_command(app, "info", "Show what a volume or particles hold, and suggest an iso value.", line->info_flags);
  line->verify =
      add_command(app, "verify", "Compare GPU and CPU, or a written mesh with its volume, triangle by triangle.",
                  line->verify_flags);
  line->compare = add_command(app, "compare", "Compare two meshes: their topology, and the distances between them.",
                              line->compare_flags);
  line->check =
      add_command(app, "check", "Say what is wrong with a mesh, for printing, engines and solvers.", line->check_flags);
  line->render = add_command(app, "render", "Draw volumes, surfaces and meshes as pictures, as PNG or OpenEXR.",
                             line->render_flags);
  line->bench =
      add_command(app, "bench", "Measure error against run time of all methods, and draw it.", line->bench_flags);
  line->stability = add_command(app, "stability", "Extract extreme fields with every method, and check every vertex.",
                                line->stability_flags);
  line->merge = add_command(app, "merge", "Join the manifests of the shards of a batch, and check that all is there.",
                            line->merge_flags);
  line->devices = add_command(app, "devices", "List the GPUs that can be used without a display.", line->devices_flags);
  line->simulate =
      add_command(app, "simulate", "Simulate what surfaces can be extracted from, and write it as a sequence.",
                  line->simulate_flags);
  line->simulate->require_subcommand(1);
  line->simulate_water =
      add_command(*line->simulate, "water", "Let water run over hilly land, by a cellular automaton, as volumes.",
                  line->water_flags);
  line->simulate_jet =
      add_command(*line->simulate, "jet", "Let a jet of water into a tank, by position-based fluids, as particles.",
                  line->jet_flags);
  line->help = add_command(app, "help", "Explain a command or a topic.", line->help_flags);
  line->generate =
      add_command(app, "generate", "Write the man page or a shell completion to stdout.", line->generate_flags);
  return line;
}

}  // namespace isoextract::cli
