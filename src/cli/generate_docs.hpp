// The man page and the shell completions, made from the declarations of the command line.
#pragma once

#include <array>
#include <string>

#include "base/words.hpp"

namespace CLI {
class App;
}

namespace isoextract::cli {

enum class Document { man, bash, zsh, fish };
constexpr auto words_of(Document /*type*/) {
  return std::array{Word{Document::man, "man"}, Word{Document::bash, "bash"}, Word{Document::zsh, "zsh"},
                    Word{Document::fish, "fish"}};
}

[[nodiscard]] std::string generate_document(const CLI::App& app, Document document);

// One of each, in a file of its own.
[[nodiscard]] std::string man_page(const CLI::App& app);
[[nodiscard]] std::string bash_completion(const CLI::App& app);
[[nodiscard]] std::string zsh_completion(const CLI::App& app);
[[nodiscard]] std::string fish_completion(const CLI::App& app);

}  // namespace isoextract::cli
