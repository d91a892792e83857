#include "cli/config_file.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"
#include "cli/command_line.hpp"
#include "files/file_bytes.hpp"
#include "files/text_file.hpp"

namespace isoextract::cli {
namespace {

constexpr std::string_view kInputKey = "input";
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;

// An option of the file as words of the command line; no words if it is false.
struct ConfigOption {
  const Option* option = nullptr;
  std::vector<std::string> words;
};

struct ConfigFile {
  std::vector<std::string> inputs;
  std::vector<ConfigOption> options;
};

class ConfigReader {
 public:
  explicit ConfigReader(const CommandOf<ConvertFlags>& command)
      : path_(*command.flags().config), config_(command.flags().config), command_(command) {}

  Result<ConfigFile> read() {
    const auto text = TRY(files::read_text_file(path_, "a file of options", kMostBytes, Context()));
    try {
      for (const auto& [key, node] : toml::parse(std::string_view(text), std::string_view(path_))) {
        TRY(take(std::string(key.str()), node));
      }
    } catch (const toml::parse_error& error) {
      return fail(ErrorCode::usage, fmt::format("{}:{}: {}", printable(path_), error.source().begin.line,
                                                printable(error.description())));
    }
    return std::move(file_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> bad(const toml::node& node, const std::string& what, Hint hint = {}) const {
    return fail(ErrorCode::usage, fmt::format("{}:{}: {}", printable(path_), node.source().begin.line, what),
                std::move(hint));
  }

  Result<void> take(const std::string& key, const toml::node& node) {
    if (key == kInputKey) {
      file_.inputs = TRY(texts_of(key, node));
      return {};
    }
    const Option* const option = command_.options().find("--" + key);
    if (option == nullptr || !may_stand_in_file(*option)) return unknown(key, node);
    auto words = TRY(words_of_value(key, *option, node));
    file_.options.push_back({option, std::move(words)});
    return {};
  }

  [[nodiscard]] bool may_stand_in_file(const Option& option) const { return !option.help() && &option != &config_; }

  [[nodiscard]] tl::unexpected<Error> unknown(const std::string& key, const toml::node& node) const {
    std::vector<std::string> known{std::string(kInputKey)};
    for (const Option* option : command_.options().options()) {
      if (!option->is_positional() && may_stand_in_file(*option)) known.push_back(option->key());
    }
    const std::string near = nearest_name(key, known);
    return bad(node, fmt::format("unknown key '{}'", printable(key)),
               near.empty() ? "the keys are 'input' and the long names of the options of convert, without dashes"
                            : fmt::format("did you mean '{}'?", near));
  }

  Result<std::vector<std::string>> words_of_value(const std::string& key, const Option& option,
                                                  const toml::node& node) const {
    const std::string name = "--" + key;
    if (const auto is_on = node.value_exact<bool>(); is_on && (!option.takes_value() || option.row().left_out)) {
      if (!*is_on) return std::vector<std::string>();
      const auto words = option.choices();
      return std::vector<std::string>{words.empty() ? name : fmt::format("{}={}", name, words.front())};
    }
    if (!option.takes_value())
      return bad(node, fmt::format("{}: expected true or false, found {}", key, kind_of(node)));
    const bool is_repeatable = option.is_repeatable();
    const bool has_parts = option.row().metavar.find(',') != std::string::npos;
    const toml::array* const list = node.as_array();
    const auto all_of_list = [&](const auto& is) {
      return list != nullptr && std::all_of(list->begin(), list->end(), is);
    };
    if (is_repeatable && has_parts && all_of_list([](const toml::node& one) { return one.is_array(); })) {
      std::vector<std::string> words;
      for (const toml::node& one : *list) {
        auto texts = texts_of(key, one);
        if (!texts) return texts;
        words.push_back(fmt::format("{}={}", name, fmt::join(*texts, ",")));
      }
      return words;
    }
    auto texts = texts_of(key, node);
    if (!texts) return tl::unexpected(texts.error());
    if (!is_repeatable && !has_parts && list != nullptr) {
      return bad(node, fmt::format("{}: expected one value, found a list of {}", key, texts->size()));
    }
    // Numbers in a list are the parts of one value; texts are separate values.
    if (has_parts && list != nullptr &&
        (!is_repeatable || all_of_list([](const toml::node& one) { return one.is_number(); }))) {
      *texts = {fmt::format("{}", fmt::join(*texts, ","))};
    }
    for (std::string& text : *texts) text = fmt::format("{}={}", name, text);
    return texts;
  }

  // Returns the text of the value, or of each entry of a list.
  Result<std::vector<std::string>> texts_of(const std::string& key, const toml::node& node) const {
    std::vector<std::string> texts;
    const toml::node* cut = nullptr;  // a text with a NUL character, which would truncate a path
    const auto add = [&](const toml::node& value) {
      if (const auto* text = value.as_string()) {
        texts.push_back(text->get());
        if (texts.back().find('\0') != std::string::npos) cut = &value;
      } else if (const auto* whole = value.as_integer()) {
        texts.push_back(fmt::format("{}", whole->get()));
      } else if (const auto* number = value.as_floating_point()) {
        texts.push_back(fmt::format("{}", number->get()));
      } else {
        return false;
      }
      return true;
    };
    const toml::node* wrong = nullptr;
    if (const auto* list = node.as_array()) {
      for (const toml::node& value : *list) {
        if (wrong == nullptr && !add(value)) wrong = &value;
      }
    } else if (!add(node)) {
      wrong = &node;
    }
    if (cut != nullptr) return bad(*cut, fmt::format("{}: expected a text without NUL characters", key));
    if (wrong == nullptr) return texts;
    return bad(*wrong, fmt::format("{}: expected a text, a number or a list of them, found {}", key, kind_of(*wrong)));
  }

  static std::string_view kind_of(const toml::node& node) {
    if (node.is_table()) return "a table";
    if (node.is_array()) return "a list";
    if (node.is_boolean()) return "true or false";
    if (node.is_string()) return "a text";
    return node.is_number() ? "a number" : "a date or time";
  }

  const std::string& path_;
  const Option& config_;  // the --config option, which the file must not have
  const CommandOf<ConvertFlags>& command_;
  ConfigFile file_;
};

void append(std::vector<std::string>& words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
}

}  // namespace

Result<std::vector<std::string>> with_config(CommandOf<ConvertFlags>& command,
                                             const std::vector<std::string>& arguments) {
  const std::string path = *command.flags().config;
  if (files::is_standard_input(path)) return fail(ErrorCode::usage, "--config needs the name of a file, found '-'");
  const auto file = TRY(ConfigReader(command).read());
  std::vector<std::string> all;  // the words of the whole file
  std::vector<std::string> words;
  for (const ConfigOption& option : file.options) {
    append(all, option.words);
    if (option.option->texts().empty()) append(words, option.words);
  }
  // Parses the file's words separately, so that errors name the file.
  command.forget();
  if (auto checked = parse_words(command, all); !checked) {
    Error error = std::move(checked.error());
    error.message = fmt::format("{}: {}", printable(path), error.message);
    return tl::unexpected(std::move(error));
  }

  const std::vector<std::string> given = arguments_after_command(command, arguments);
  std::vector<std::string> configured(arguments.begin(), arguments.end() - std::ssize(given));
  append(configured, words);
  append(words, given);
  command.forget();
  TRY(parse_words(command, words));
  // Sets inputs directly, since as words they could look like options.
  std::vector<std::string>& inputs = command.flags().input.inputs;
  if (inputs.empty()) {
    inputs = file.inputs;
    append(configured, inputs);
  }
  append(configured, given);
  return configured;
}

}  // namespace isoextract::cli
