#include "cli/messages.hpp"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "base/allocation_error.hpp"
#include "base/printable.hpp"
#include "cli/rank_run.hpp"
#include "cli/remedies.hpp"
#include "cli/terminal.hpp"
#include "files/output_file.hpp"

namespace isoextract::cli {
namespace {

spdlog::level::level_enum level_of(Verbosity verbosity) {
  switch (verbosity) {
    case Verbosity::quiet: return spdlog::level::err;
    case Verbosity::normal: return spdlog::level::info;
    case Verbosity::verbose: break;
  }
  return spdlog::level::debug;
}

// Escape sequences of a terminal.
constexpr std::string_view kRed = "\x1b[1;31m";
constexpr std::string_view kYellow = "\x1b[33m";
constexpr std::string_view kCyan = "\x1b[36m";
constexpr std::string_view kUncolored = "\x1b[0m";

// Makes each line of a text printable. Line breaks are those of the text itself, since callers make names printable.
std::string printable_lines(std::string_view text) {
  std::string shown;
  while (true) {
    const std::size_t end = text.find('\n');
    shown += printable(text.substr(0, end));
    if (end == std::string_view::npos) return shown;
    shown += '\n';
    text.remove_prefix(end + 1);
  }
}

}  // namespace

Messages::Messages(MessageChoice choice)
    : choice_(std::move(choice)),
      colors_(stderr_has_colors()),
      log_(std::make_shared<spdlog::logger>("isoextract", std::make_shared<spdlog::sinks::stderr_sink_mt>())) {
  if (is_later_rank()) choice_.verbosity = Verbosity::quiet;
  log_->set_pattern("%v");
  log_->set_level(is_later_rank() ? spdlog::level::off : level_of(choice_.verbosity));
}

std::string Messages::colored(std::string_view word, std::string_view color) const {
  return colors_ ? fmt::format("{}{}{}", color, word, kUncolored) : std::string(word);
}

void Messages::error(const Error& error) const {
  log_->error("isoextract: {} {}", colored("error:", kRed), printable(error.message));
  const std::string hint = hint_text(error.hint);
  if (!hint.empty()) log_->error("  {} {}", colored("hint:", kCyan), printable_lines(hint));
}

void Messages::note(const Note& note) const {
  if (std::ranges::find(choice_.hidden, note.id) != choice_.hidden.end()) return;
  log_->warn("isoextract: {} {}", colored(fmt::format("note[{}]:", word_of(note.id)), kYellow), printable(note.text));
}
void Messages::summary(std::string_view text) const { log_->info("{}", printable(text)); }
void Messages::explanation(std::string_view text) const { log_->info("{}", printable(text)); }
void Messages::detail(std::string_view text) const { log_->debug("{}", printable(text)); }

Error error_of_exception() {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return allocation_error("not enough memory", {Remedy::use, Setting::parts});
  } catch (const std::exception& error) {
    return {ErrorCode::input, fmt::format("internal error: {}", error.what()), "please report this message"};
  }
}

Result<void> print_to_stdout(std::string_view text) {
  auto out = TRY(files::OutputFile::create("-"));
  TRY(out.write(text));
  return out.commit();
}

}  // namespace isoextract::cli
