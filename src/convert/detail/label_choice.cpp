#include "convert/detail/label_choice.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/counted.hpp"
#include "base/nearest_name.hpp"
#include "base/parallel.hpp"
#include "base/printable.hpp"
#include "convert/label_selection.hpp"
#include "extract/label_map_size.hpp"

namespace isoextract::convert {
namespace {

// Returns the number that a text is, whatever its size and notation: 1.5, 1e3, inf, nan.
std::optional<double> number_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  return error == std::errc() ? number : std::numeric_limits<double>::infinity();
}

// Returns whether the text is the number of a label.
bool is_label_number(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size();
}

// Returns the hint if no label is `given`: "did you mean 'Spleen'?", what labels are, or the names that there are.
std::string hint_of_labels(const std::string& given, const std::vector<std::string>& names) {
  constexpr std::size_t kMostTold = 12;
  constexpr double kMostExact = 0x1p53;  // up to here a double is the number that the text is
  const auto same = std::ranges::find(names, to_lower(given), [](const std::string& name) { return to_lower(name); });
  const std::string near = same != names.end() ? *same : nearest_name(given, names);
  if (!near.empty()) return fmt::format("did you mean '{}'?", printable(near));
  if (const auto number = number_of(given)) {
    const bool is_whole = std::abs(*number) <= kMostExact && *number == std::floor(*number);
    return is_whole ? fmt::format("did you mean {:.0f}?", *number) : "labels are whole numbers from -2^63 to 2^63 - 1";
  }
  if (names.empty()) return "the labels have no names: give their numbers";
  std::vector<std::string> told;
  for (const std::string& name : std::span(names).first(std::min(names.size(), kMostTold))) {
    told.push_back(printable(name, 40));
  }
  return fmt::format("the names are {}{}", fmt::join(told, ", "), names.size() > kMostTold ? ", ..." : "");
}

// Removes the labels that are not in the selection. Fails if a number or name in the selection matches no label, unless
// `empty` allows it; adds notes about other terms that match no label.
Result<void> select(const std::string& text, const LabelAppearance& looks, EmptyPolicy empty, const std::string& source,
                    ChosenLabels& chosen) {
  auto selection = LabelSelection::parse(text);
  if (!selection) return {};  // a job's selections are valid
  std::erase_if(chosen.labels,
                [&](std::int64_t label) { return !selection->contains(label, looks.given_name(label)); });
  // A term may be meant for labels of another layer.
  for (const field::LabelName& other : looks.of_other_layers()) {
    static_cast<void>(selection->contains(other.label, other.name));
  }
  const std::vector<std::string> names = looks.names();
  std::vector<std::string> without_sample;  // names of labels
  std::vector<std::string> terms;           // of no label
  for (const LabelSelection::UnmatchedTerm& term : selection->unmatched()) {
    const bool is_known = std::ranges::find(names, term.text) != names.end();
    if (term.is_one_label && empty == EmptyPolicy::error) {
      if (is_known) {
        return fail(ErrorCode::no_surface,
                    fmt::format("{}: no sample has the label '{}'", source, printable(term.text)),
                    {Remedy::use, Setting::empty_policy});
      }
      Hint hint = is_label_number(term.text) ? Hint() : Hint(hint_of_labels(term.text, names));
      hint.steps.emplace_back(Remedy::use, Setting::empty_policy);
      return fail(ErrorCode::no_surface, fmt::format("{}: no label is '{}'", source, printable(term.text)),
                  std::move(hint));
    }
    (is_known ? without_sample : terms).push_back(fmt::format("'{}'", printable(term.text)));
  }
  if (!without_sample.empty()) {
    chosen.notes.push_back({NoteId::labels_unmatched,
                            fmt::format("{}: no sample has the label {}", source, fmt::join(without_sample, " or "))});
  }
  if (terms.empty()) return {};
  chosen.notes.push_back(
      {NoteId::labels_unmatched, fmt::format("{}: no label matches {}", source, fmt::join(terms, " or "))});
  return {};
}

void drop_small(const extract::LabelVoxels& found, std::uint64_t least, const std::string& source,
                ChosenLabels& chosen) {
  const std::size_t before = chosen.labels.size();
  std::vector<std::int64_t> small;
  std::erase_if(chosen.labels, [&](std::int64_t label) {
    const extract::FoundLabel* const entry = found.find(label);
    if (entry == nullptr || entry->voxels >= least) return false;
    small.push_back(label);
    return true;
  });
  if (small.empty()) return;
  chosen.too_small.insert(small.begin(), small.end());
  constexpr std::size_t kMostTold = 10;
  const std::size_t told = std::min(small.size(), kMostTold);
  chosen.notes.push_back({NoteId::labels_small,
                          fmt::format("{}: no mesh for {} of {} ({}{}): they have fewer than {}", source, small.size(),
                                      counted(before, "label"), fmt::join(std::span(small).first(told), ", "),
                                      told < small.size() ? ", ..." : "", counted(least, "voxel"))});
}

}  // namespace

Result<ChosenLabels> choose_labels(std::span<const ResolvedIso> asked, const extract::LabelVoxels& found,
                                   const LabelAppearance& looks, std::uint64_t least, EmptyPolicy empty,
                                   const std::string& source) {
  ChosenLabels chosen;
  chosen.labels = found.labels();
  const auto set = std::ranges::find_if(asked, [](const ResolvedIso& iso) { return iso.asked.is_label_set(); });
  if (set != asked.end() && set->asked.kind == IsoChoice::Kind::selected_labels) {
    TRY(select(set->asked.selection, looks, empty, source, chosen));
  }
  drop_small(found, least, source, chosen);
  chosen.counts = {found.labels().size(), chosen.too_small.size()};
  return chosen;
}

Result<void> check_piece_names(const ConversionJob& job, const ChosenLabels& chosen, const LabelAppearance& looks,
                               const std::string& source) {
  for (const OutputFileJob& output : job.outputs) {
    if (output.isos.size() != 1 || !output.isos.front().is_label_name()) continue;
    const auto uses = [&](std::string_view word) { return output.path.find(word) != std::string::npos; };
    if (!uses(kPiecePlaceholder) || uses(kLabelPlaceholder) || uses(kNamePlaceholder)) continue;
    const std::string& name = output.isos.front().selection;
    const std::vector<field::LabelName> others = looks.of_other_layers();
    const bool is_shared =
        chosen.labels.size() > 1 || std::ranges::find(others, name, &field::LabelName::name) != others.end();
    if (!is_shared) continue;
    return fail(ErrorCode::usage,
                fmt::format("{}: several labels have the name '{}', and their bodies would have the same file names",
                            source, printable(name)),
                "put {label} into the file name as well");
  }
  return {};
}

LabelGroup next_group(std::span<const ResolvedIso> next, const extract::LabelVoxels& found) {
  if (next.empty()) return {};
  if (usable_threads() == 1) return {1, false};
  std::size_t size = 0;
  for (std::uint64_t chunks = 0; size < std::min(next.size(), extract::kSmallLabels); ++size) {
    const extract::FoundLabel* const label = found.find(next[size].id.label());
    chunks += label != nullptr ? label->chunks : 0;
    if (chunks > extract::kSmallLabelChunks) break;
  }
  return size > 0 ? LabelGroup{size, true} : LabelGroup{1, false};
}

}  // namespace isoextract::convert
