// `isoextract formats`: lists what can be read and written, and with which library.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/command.hpp"
#include "cli/format_list.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"
#include "convert/json_documents.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

struct FormatsFlags : OptionSet {
  JsonFlag json{in(OptionGroup::output), "Report as JSON, an array with one entry a format."};
  RunFlags run{*this, RunFlags::Taken::quiet};  // prints only its results
};

std::string heading(FormatUse use) {
  switch (use) {
    case FormatUse::read_volume: return "Volumes that isoextract reads";
    case FormatUse::read_particles: return "Particles that isoextract reads";
    case FormatUse::unpack: return "Packed files that isoextract opens";
    case FormatUse::write_mesh: return "Meshes that isoextract reads and writes";
    case FormatUse::write_field: return "Fields that isoextract writes";
    case FormatUse::write_particles: break;
  }
  return "Particles that isoextract writes";
}

// Returns "built in, with teem", or the path of the plug-in, or the package that a missing plug-in needs.
std::string source_text(const ListedFormat& format) {
  if (!format.is_plugin) return format.library.empty() ? "built in" : fmt::format("built in, with {}", format.library);
  const std::string library = format.library.empty() ? "plug-in" : fmt::format("plug-in with {}", format.library);
  if (format.is_there()) return fmt::format("{}: {}", library, format.plugin);
  return format.package.empty()
             ? library + ": missing"
             : fmt::format("{}: missing; the package {} and a new build bring it", library, format.package);
}

convert::Json json_of(const ListedFormat& format) {
  return {{"schema", word_of(convert::JsonDocument::formats)},
          {"use", word_of(format.use)},
          {"id", format.id},
          {"title", format.title},
          {"extensions", format.extensions},
          {"library", format.library},
          {"is_plugin", format.is_plugin},
          {"plugin", format.plugin.empty() ? convert::Json(nullptr) : convert::Json(format.plugin)},
          {"package", format.package},
          {"is_there", format.is_there()}};
}

class FormatsCommand final : public CommandOf<FormatsFlags> {
 public:
  FormatsCommand() : CommandOf({"formats", "[options]", "List the formats, and the libraries that read them."}) {}

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    const std::vector<ListedFormat> formats = list_formats();
    std::string text =
        "isoextract finds the format of an input by the content of the file, then by its extension; --input-format\n"
        "overrides both.\n\n";
    convert::Json json = convert::Json::array();
    for (std::size_t i = 0; i < formats.size(); ++i) {
      const ListedFormat& format = formats[i];
      json.push_back(json_of(format));
      if (i == 0 || formats[i - 1].use != format.use) text += (i == 0 ? "" : "\n") + heading(format.use) + "\n";
      text += fmt::format("  {:<9} {}", format.id, format.title);
      if (!format.extensions.empty()) text += fmt::format(" ({})", fmt::join(format.extensions, " "));
      text += fmt::format("\n            {}\n", source_text(format));
    }
    TRY(print_to_stdout(flags().json ? convert::json_text(json) : text));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_formats_command() { return std::make_unique<FormatsCommand>(); }

}  // namespace isoextract::cli
