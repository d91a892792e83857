#include "batch/existing_files.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <unordered_map>
#include <utility>

#include "base/ascii.hpp"
#include "convert/surface_edits.hpp"
#include "files/folder_names.hpp"
#include "files/output_file.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::array kLabelWords{convert::kLabelPlaceholder, convert::kNamePlaceholder};

bool has_label_word(const fs::path& output) {
  const std::string name = output.filename().string();
  return std::ranges::any_of(kLabelWords, [&](std::string_view word) { return name.find(word) != std::string::npos; });
}

std::size_t count_digits(std::string_view text) { return std::min(text.find_first_not_of(kDigits), text.size()); }

// Returns the length of the longest text at the start of the path that {label} or {name} may stand for; 0 if none may.
std::size_t longest_text(std::string_view path, bool is_label) {
  if (!is_label) return std::min(path.find('/'), path.size());
  const std::size_t sign = path.starts_with('-') ? 1 : 0;
  const std::size_t end = sign + count_digits(path.substr(sign));
  if (end == sign || !path.substr(end).starts_with('_')) return end > sign ? end : 0;
  return end + 1 + count_digits(path.substr(end + 1));
}

// Returns whether {label} stands for the text: 5, -5, or 5_2 for the second label 5 of a map with several layers.
bool is_label_text(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  const std::size_t end = count_digits(text);
  if (end == 0 || end == text.size()) return end > 0;
  const std::string_view repeat = text.substr(end + 1);
  return text[end] == '_' && !repeat.empty() && repeat.front() != '0' && repeat != "1" &&
         count_digits(repeat) == repeat.size();
}

// Returns the texts that begin with `start`.
std::span<const std::string> texts_with_start(const std::vector<std::string>& sorted, std::string_view start) {
  const auto first = std::lower_bound(sorted.begin(), sorted.end(), start);
  const auto last =
      std::partition_point(first, sorted.end(), [&](const std::string& text) { return text.starts_with(start); });
  return {first, last};
}

std::string reversed_text(std::string_view text) { return {text.rbegin(), text.rend()}; }

}  // namespace

std::optional<std::string> match_output_name(std::string_view path, std::string_view name) {
  std::string filled;
  while (!name.empty()) {
    const bool is_label = name.starts_with(convert::kLabelPlaceholder);
    if (is_label || name.starts_with(convert::kNamePlaceholder)) {
      name.remove_prefix(is_label ? convert::kLabelPlaceholder.size() : convert::kNamePlaceholder.size());
      for (std::size_t length = longest_text(path, is_label); length > 0; --length) {
        if (is_label && !is_label_text(path.substr(0, length))) continue;
        if (const auto rest = match_output_name(path.substr(length), name)) {
          return filled.append(path.substr(0, length)).append(*rest);
        }
      }
      return std::nullopt;
    }
    const bool is_piece = name.starts_with(convert::kPiecePlaceholder);
    const std::string_view same = name.substr(0, is_piece ? convert::kPiecePlaceholder.size() : 1);
    if (path.empty() || path.front() != (is_piece ? '1' : same.front())) return std::nullopt;
    filled.append(same);
    name.remove_prefix(same.size());
    path.remove_prefix(1);
  }
  return path.empty() ? std::optional(filled) : std::nullopt;
}

const ExistingFiles::Listing& ExistingFiles::list(const fs::path& folder) {
  const auto [place, is_new] = folders_.try_emplace(folder);
  Listing& listing = place->second;
  if (!is_new) return listing;
  const auto read = files::visit_folder(folder.string(), [&](std::string name, const fs::directory_entry& entry) {
    std::error_code none;
    if (entry.is_symlink(none) && !files::is_there(entry.path())) return;
    listing.reversed.push_back(reversed_text(name));
    listing.names.push_back(std::move(name));
  });
  if (!read) listing = {};
  std::ranges::sort(listing.names);
  std::ranges::sort(listing.reversed);
  return listing;
}

std::vector<ExistingFiles::Match> ExistingFiles::find_matches(const fs::path& output) {
  const Listing& listing = list(output.parent_path());
  const std::string name = output.filename().string();
  std::size_t first = name.size();  // end of the text before all placeholders
  std::size_t last = 0;             // start of the text after all placeholders
  for (const std::string_view word : {kLabelWords[0], kLabelWords[1], convert::kPiecePlaceholder}) {
    first = std::min(first, name.find(word));
    if (const std::size_t at = name.rfind(word); at != std::string::npos) last = std::max(last, at + word.size());
  }
  // Compares only names with the same start or end as the output name: comparing all names for each frame is slow.
  const auto with_start = texts_with_start(listing.names, std::string_view(name).substr(0, first));
  const auto with_end = texts_with_start(listing.reversed, reversed_text(std::string_view(name).substr(last)));
  const bool by_end = with_end.size() < with_start.size();
  std::vector<Match> matches;
  for (const std::string& text : by_end ? with_end : with_start) {
    const std::string file = by_end ? reversed_text(text) : text;
    if (const auto filled = match_output_name(file, name)) {
      matches.push_back({output.parent_path() / file, (output.parent_path() / *filled).string()});
    }
  }
  std::ranges::sort(matches, {}, &Match::output);
  return matches;
}

std::vector<fs::path> ExistingFiles::find(const convert::ConversionJob& job) {
  std::vector<fs::path> found = find_label_files(job);
  std::ranges::copy_if(files_of(job), std::back_inserter(found),
                       [](const fs::path& file) { return !has_label_word(file) && files::is_there(file); });
  return found;
}

std::vector<fs::path> ExistingFiles::find_label_files(const convert::ConversionJob& job) {
  std::vector<fs::path> found;
  for (const fs::path& file : files_of(job)) {
    if (!has_label_word(file)) continue;
    for (Match& match : find_matches(file)) found.push_back(std::move(match.file));
  }
  return found;
}

std::vector<convert::OutputFileJob> ExistingFiles::find_label_outputs(const convert::ConversionJob& job) {
  std::vector<convert::OutputFileJob> found;
  for (const convert::OutputFileJob& output : job.outputs) {
    if (!has_label_word(output.path)) continue;
    for (Match& match : find_matches(output.path)) found.push_back({std::move(match.output), output.isos});
  }
  return found;
}

std::vector<std::vector<convert::OutputFileJob>> find_label_outputs(const BatchJob& batch) {
  constexpr std::size_t kSeveral = SIZE_MAX;
  ExistingFiles existing;
  std::vector<std::vector<convert::OutputFileJob>> outputs;
  std::unordered_map<std::string, std::size_t> frames;  // the frame that each output belongs to
  for (std::size_t i = 0; i < batch.frames.size(); ++i) {
    outputs.push_back(existing.find_label_outputs(batch.frames[i].job));
    for (const convert::OutputFileJob& output : outputs.back()) {
      const auto [place, is_new] = frames.try_emplace(output.path, i);
      if (!is_new && place->second != i) place->second = kSeveral;
    }
  }
  for (std::vector<convert::OutputFileJob>& of_frame : outputs) {
    std::erase_if(of_frame, [&](const convert::OutputFileJob& output) { return frames[output.path] == kSeveral; });
  }
  return outputs;
}

}  // namespace isoextract::batch
