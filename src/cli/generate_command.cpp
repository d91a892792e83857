// `isoextract generate`: prints the man page and the completions that are installed.
#include "cli/command.hpp"
#include "cli/generate_docs.hpp"
#include "cli/messages.hpp"
#include "cli/options/run.hpp"

namespace isoextract::cli {
namespace {

using MakeDocument = std::string (*)(const Command& program);

std::vector<Choice<MakeDocument>> documents() {
  return {{"man", man_page}, {"bash", bash_completion}, {"zsh", zsh_completion}, {"fish", fish_completion}};
}

struct GenerateFlags : OptionSet {
  Value<MakeDocument> document{in(OptionGroup::input), "DOCUMENT", documents(),
                               "The man page, or the completion script of a shell."};
  RunFlags run{*this, RunFlags::Taken::quiet};
};

class GenerateCommand final : public CommandOf<GenerateFlags> {
 public:
  GenerateCommand()
      : CommandOf({"generate", "man|bash|zsh|fish", "Write the man page or a shell completion to stdout."}) {}

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    const auto& document = flags().document;
    if (!document) return fail(ErrorCode::usage, "generate needs a document: man, bash, zsh or fish", synopsis());
    TRY(print_to_stdout((*document)(program())));
    return kDone;
  }
};

}  // namespace

std::unique_ptr<Command> make_generate_command() { return std::make_unique<GenerateCommand>(); }

}  // namespace isoextract::cli
