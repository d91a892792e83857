#include "batch/find_frames.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <numeric>
#include <string_view>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "batch/detail/decimal_names.hpp"
#include "batch/detail/input_names.hpp"
#include "batch/detail/sequences.hpp"
#include "batch/header_files.hpp"
#include "files/folder_names.hpp"
#include "files/frame_pattern.hpp"
#include "files/natural_order.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "particle_io/particle_format.hpp"
#include "volume_io/volume_format.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShownSequences = 8;
constexpr std::size_t kShownRuns = 8;
constexpr std::size_t kMaxShownName = 100;  // bytes

// The frames found, before the range selects.
struct FoundFrames {
  std::vector<Frame> frames;
  bool numbered = true;  // by their names; false: by position, which leaves no gaps
  Notes notes;
  bool have_numbers = true;
};

// Returns the numbers missing between the frames, at the greatest step that all numbers share. `frames` is not empty.
std::vector<FrameRun> gaps_between(std::span<const Frame> frames) {
  std::int64_t step = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) step = std::gcd(step, frames[i].number - frames[i - 1].number);
  std::vector<FrameRun> gaps;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FrameRun gap{frames[i - 1].number + step, frames[i].number - step, step};
    if (gap.first <= gap.last) gaps.push_back({gap.first, gap.last, gap.first == gap.last ? 1 : step});
  }
  return gaps;
}

tl::unexpected<Error> fail_too_many(const std::string& input) {
  return fail(ErrorCode::usage,
              fmt::format("{}: expected at most {} frames, found more", printable(input), kMaxFrames));
}

Result<Frames> chosen_frames(FoundFrames found, const std::optional<FrameRange>& range, const std::string& input) {
  if (range) std::erase_if(found.frames, [&](const Frame& frame) { return !range->contains(frame.number); });
  if (found.frames.empty()) {
    return fail(ErrorCode::input, fmt::format("{}: expected files of the frames {}, found none", printable(input),
                                              text_of(range->runs(), kShownRuns)));
  }
  if (found.frames.size() > kMaxFrames) return fail_too_many(input);
  std::ranges::stable_sort(found.frames, {}, &Frame::number);
  const auto twice = std::ranges::adjacent_find(found.frames, {}, &Frame::number);
  if (twice != found.frames.end()) {
    std::string first = twice->input;
    std::string second = std::next(twice)->input;
    if (second < first) std::swap(first, second);  // the order in which a folder lists files is arbitrary
    return fail(ErrorCode::input, fmt::format("expected one file for frame {}, found {} and {}", twice->number,
                                              printable(first), printable(second)));
  }
  Frames frames;
  if (range) {
    frames.gaps = gaps_of(*range, found.frames);
  } else if (found.numbered) {
    frames.gaps = gaps_between(found.frames);
  }
  frames.frames = std::move(found.frames);
  frames.notes = std::move(found.notes);
  frames.have_numbers = found.have_numbers;
  return frames;
}

Result<Frames> without_files(const files::FramePattern& pattern, const std::optional<FrameRange>& range,
                             const std::string& input) {
  if (!range) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected the numbers of the frames, because no files tell how many a demo field has",
                            printable(input)),
                {Remedy::give, Setting::frames});
  }
  Frames frames;
  for (const std::int64_t number : range->numbers()) frames.frames.push_back({number, pattern.expand(number), {}});
  return frames;
}

// A pattern split at the folder entry that contains its number.
struct EntryPattern {
  std::string folder;  // with its slash; may be empty
  files::FramePattern pattern;
  std::string rest;  // starts with a slash; may be empty
};

EntryPattern entry_pattern(const files::FramePattern& pattern) {
  const std::string& prefix = pattern.prefix();
  const std::string& suffix = pattern.suffix();
  const std::size_t name = prefix.find_last_of('/') + 1;
  const std::size_t rest = std::min(suffix.find('/'), suffix.size());
  return {prefix.substr(0, name), files::FramePattern(prefix.substr(name), pattern.width(), suffix.substr(0, rest)),
          suffix.substr(rest)};
}

// Judges the digits that stand for the pattern's number in the matching names.
FractionKind judge_numbers(const files::FramePattern& pattern, std::span<const std::string> names) {
  const std::string& prefix = pattern.prefix();
  if (names.size() < 2 || !ends_within_decimal(prefix)) return FractionKind::whole_numbers;
  if (ends_in_exponent(prefix)) return FractionKind::fractions;
  std::vector<std::string_view> digits;
  for (const std::string& name : names) {
    digits.push_back(
        std::string_view(name).substr(prefix.size(), name.size() - prefix.size() - pattern.suffix().size()));
  }
  return judge_fractions(digits);
}

// Adds a note if digits after a point could be whole numbers or fractions.
void add_note_of_unclear(const files::FramePattern& pattern, std::span<const std::string> names, FoundFrames& found) {
  if (judge_numbers(pattern, names) != FractionKind::unclear) return;
  found.notes.push_back(
      {NoteId::frame_order,
       fmt::format("{}: the digits after the point count as whole numbers: 10 follows 9", printable(pattern.text()))});
}

// Returns the hint for a pattern whose files have decimal numbers.
std::string list_files_hint(const EntryPattern& entries) {
  return fmt::format("list the files, without quotes: {}*{}; the run orders the files by their decimal numbers",
                     printable(entries.folder + entries.pattern.prefix()),
                     printable(entries.pattern.suffix() + entries.rest));
}

tl::unexpected<Error> fail_decimals(const std::string& input, const EntryPattern& entries,
                                    std::span<const std::string> names) {
  return fail(ErrorCode::usage,
              fmt::format("{}: expected whole frame numbers, found decimal numbers in the names {} and {}",
                          printable(input), printable(names.front()), printable(names.back())),
              list_files_hint(entries));
}

// Of files with decimal numbers beside those that the pattern matches. `names` is not empty.
Note note_of_decimals(const std::string& input, std::span<const std::string> names) {
  return {NoteId::frame_order,
          fmt::format("{}: the pattern stands for whole numbers; the run leaves out {} with {}, such as {}",
                      printable(input), counted(names.size(), "file"),
                      names.size() == 1 ? "a decimal number" : "decimal numbers", printable(names.front()))};
}

Result<FoundFrames> matching_files(const files::FramePattern& pattern, const std::optional<FrameRange>& range,
                                   const std::string& input) {
  const EntryPattern entries = entry_pattern(pattern);
  const files::FramePattern any_width(entries.pattern.prefix(), 0, entries.pattern.suffix());
  FoundFrames found;
  std::vector<std::string> matched;
  std::string other_width;            // a name that matches except for the width
  std::vector<std::string> decimals;  // names with decimal numbers
  TRY(files::visit_folder(entries.folder, [&](const std::string& name, const fs::directory_entry& entry) {
    const auto number = entries.pattern.match(name);
    if (!number) {
      if (any_width.match(name) && (other_width.empty() || name < other_width)) other_width = name;
      if (has_decimal_number(entries.pattern, name)) decimals.push_back(name);
      return;
    }
    std::error_code none;
    std::string path = entries.folder + name + entries.rest;
    const bool is_there = entries.rest.empty() || fs::exists(path, none);
    const bool is_folder = entries.rest.empty() ? entry.is_directory(none) : fs::is_directory(path, none);
    if (!is_there || (is_folder && !volume_io::is_volume_folder(path, Context()))) return;
    matched.push_back(name);
    if (!range || range->contains(*number)) found.frames.push_back({*number, std::move(path), {}});
  }));
  std::ranges::sort(matched);
  if (judge_numbers(entries.pattern, matched) == FractionKind::fractions) return fail_decimals(input, entries, matched);
  add_note_of_unclear(entries.pattern, matched, found);
  std::ranges::sort(decimals, files::NaturalLess());
  if (!found.frames.empty()) {
    if (!decimals.empty()) found.notes.push_back(note_of_decimals(input, decimals));
    return found;
  }
  std::string message = fmt::format("{}: no file matches this pattern", printable(input));
  if (range) message += fmt::format(" with a number in {}", text_of(range->runs(), kShownRuns));
  if (!other_width.empty()) {
    return fail(ErrorCode::input, std::move(message), fmt::format("{{}} matches {}", printable(other_width)));
  }
  if (decimals.empty()) return fail(ErrorCode::input, std::move(message));
  message +=
      fmt::format("; {} has a decimal number, and the pattern stands for whole numbers", printable(decimals.front()));
  return fail(ErrorCode::input, std::move(message), list_files_hint(entries));
}

std::string note_by_position(std::size_t count) {
  return fmt::format(
      "the file names do not differ in exactly one number: the run numbers the frames 1 to {} by their order", count);
}

std::string note_by_decimals(const std::string& first, const std::string& last, std::size_t count) {
  return fmt::format(
      "the file names differ in a decimal number: the run numbers the frames 1 to {} by its value, from {} to {}",
      count, printable(first), printable(last));
}

// Numbers the files of one sequence by their names. Numbers other files from 1, sorted by their decimal numbers if any.
FoundFrames numbered_frames(std::span<const std::string> names, std::span<const Sequence> sequences,
                            const std::optional<DecimalOrder>& decimals, const std::string& folder) {
  FoundFrames found;
  found.numbered = sequences.size() == 1 && !decimals;
  found.have_numbers = found.numbered || decimals;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t name = decimals ? decimals->names[i] : i;
    const std::int64_t number = found.numbered ? sequences.front().members[i].number : static_cast<std::int64_t>(i) + 1;
    found.frames.push_back({number, folder + names[name], {}});
  }
  if (decimals) {
    found.notes.push_back({NoteId::frame_order, note_by_decimals(names[decimals->names.front()],
                                                                 names[decimals->names.back()], names.size())});
  } else if (!found.numbered) {
    found.notes.push_back({NoteId::frame_order, note_by_position(names.size())});
  } else if (const auto pattern = files::FramePattern::parse(sequences.front().pattern); pattern && *pattern) {
    add_note_of_unclear(**pattern, names, found);
  }
  return found;
}

tl::unexpected<Error> fail_several(const std::string& folder, std::span<const Sequence> sequences) {
  std::string list;
  for (const Sequence& sequence : sequences.first(std::min(sequences.size(), kShownSequences))) {
    list += fmt::format("{}{}", list.empty() ? "" : ", ", printable(sequence.pattern));
    if (sequence.members.size() > 1) list += fmt::format(" ({} files)", sequence.members.size());
  }
  if (sequences.size() > kShownSequences) list += ", ...";
  return fail(
      ErrorCode::usage,
      fmt::format("{}: expected one sequence in the folder, found {}: {}", printable(folder), sequences.size(), list),
      "give the pattern of one sequence, with the folder before the pattern");
}

// The folder may hold files of a known kind without telling names, such as a DICOM series.
tl::unexpected<Error> fail_no_names(const std::string& folder, const std::string& first) {
  std::string message = fmt::format("{}: no file in the folder has the extension of a volume, particle or mesh format",
                                    printable(folder));
  Hint hint("give a pattern, with the folder before it, to find files of any name");
  if (const auto known =
          first.empty() ? std::nullopt : volume_io::unsupported_format_error(fs::path(folder) / first, Context())) {
    message += fmt::format("; {}", known->message);
    hint = known->hint;
  }
  return fail(ErrorCode::input, std::move(message), std::move(hint));
}

// Finds volumes, else particles, else pictures, else meshes: tables, meshes and pictures often lie beside volumes.
Result<FoundFrames> files_of_folder(const std::string& folder) {
  std::vector<std::string> names;
  std::vector<std::string> particles;
  std::vector<std::string> pictures;
  std::vector<std::string> meshes;
  CountedFiles unknown;
  TRY(files::visit_folder(folder, [&](const std::string& name, const fs::directory_entry& entry) {
    std::error_code none;
    if (name.starts_with('.') || entry.is_directory(none)) return;
    if (volume_io::has_picture_extension(name)) {
      pictures.push_back(name);
    } else if (has_header_beside(folder, name)) {
      return;  // read with its header
    } else if (volume_io::has_volume_extension(name)) {
      names.push_back(name);
    } else if (particle_io::has_particle_extension(name)) {
      particles.push_back(name);
    } else if (mesh_io::mesh_format_by_path(name)) {
      meshes.push_back(name);
    } else {
      unknown.add(name);
    }
  }));
  std::string_view kind = "volume file";
  const auto take = [&](std::vector<std::string>& files, std::string_view kind_of_files) {
    if (!names.empty() || files.empty()) return;
    kind = kind_of_files;
    names = std::exchange(files, {});
  };
  take(particles, "particle file");
  take(pictures, "picture");
  take(meshes, "mesh file");
  if (names.empty()) return fail_no_names(folder, unknown.first);
  std::ranges::sort(names, files::NaturalLess());
  const std::vector<Sequence> sequences = sequences_of(names);
  const auto is_several = [](const Sequence& sequence) { return sequence.members.size() > 1; };
  const auto decimals = order_by_decimals(names);
  const bool is_one = sequences.size() == 1 || (decimals && !decimals->may_be_two_numbers);
  if (!is_one && std::ranges::any_of(sequences, is_several)) return fail_several(folder, sequences);
  FoundFrames found = numbered_frames(names, sequences, decimals, folder.ends_with('/') ? folder : folder + '/');
  CountedFiles others = unknown;
  for (const std::string& name : particles) others.add(name);
  for (const std::string& name : meshes) others.add(name);
  CountedFiles skipped_pictures;
  for (const std::string& name : pictures) skipped_pictures.add(name);
  if (others.count + skipped_pictures.count > 0) {
    const CountedFiles taken{names.size(), names.front()};
    found.notes.push_back(note_of_other_files(folder, kind, taken, skipped_pictures, others));
  }
  return found;
}

Result<FoundFrames> listed_files(std::span<const std::string> inputs) {
  std::unordered_set<std::string_view> known;
  bool all_files = true;
  for (const std::string& input : inputs) {
    if (!known.insert(input).second) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected each input once, found this input twice", printable(input)));
    }
    fs::file_status status;
    if (std::error_code none; is_file_name(input)) {
      status = fs::status(input, none);
    } else {
      all_files = false;
    }
    const bool is_folder = fs::is_directory(status);
    if (fs::exists(status) && (!is_folder || volume_io::is_volume_folder(input, Context()))) continue;
    if (volume_io::find_inner_path(input)) continue;
    if (!fs::exists(status) && is_file_name(input) && input.find_first_of("./{#*") == std::string::npos) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected a file as one of {} inputs, found no file of this name", printable(input),
                              inputs.size()),
                  "if the word belongs to an option's value, quote the whole value");
    }
    bool several = is_folder;
    if (!several) {
      const auto pattern = TRY(files::FramePattern::parse(input));
      several = pattern.has_value();
    }
    if (!several) continue;
    return fail(ErrorCode::usage,
                fmt::format("{}: expected files, found a {} as one of {} inputs", printable(input),
                            fs::is_directory(status) ? "folder" : "pattern", inputs.size()),
                "give the folder or the pattern as the only input");
  }
  if (all_files) return numbered_frames(inputs, sequences_of(inputs), order_by_decimals(inputs), {});
  FoundFrames found{{}, false, {{NoteId::frame_order, note_by_position(inputs.size())}}, false};
  for (const std::string& input : inputs) {
    found.frames.push_back({static_cast<std::int64_t>(found.frames.size()) + 1, input, {}});
  }
  return found;
}

// Fails if the inputs are slices of one volume: a frame of one slice has no surface.
Result<void> check_slices(std::span<const std::string> inputs) {
  if (!std::ranges::all_of(inputs, [](const std::string& input) { return volume_io::has_picture_extension(input); }))
    return {};
  const std::vector<Sequence> sequences = sequences_of(inputs);
  if (sequences.size() != 1 || !volume_io::is_slice_stack(sequences.front().pattern, Context())) return {};
  const std::string pattern = printable(sequences.front().pattern);
  return fail(ErrorCode::usage,
              fmt::format("{} and {} more: expected volumes as frames, found slices of the one volume {}",
                          printable(inputs.front()), inputs.size() - 1, pattern),
              fmt::format("give the pattern '{}', in quotes, to read all its slices, or the folder, if it holds only "
                          "the slices that you want",
                          pattern));
}

}  // namespace

void CountedFiles::add(const std::string& name) {
  if (count == 0 || files::NaturalLess()(name, first)) first = name;
  ++count;
}

Note note_of_other_files(const std::string& folder, std::string_view kind, const CountedFiles& taken,
                         const CountedFiles& pictures, const CountedFiles& others) {
  // "1 picture (a.png)", "8 pictures (such as a.png)"
  const auto text = [](const CountedFiles& files, std::string_view noun) {
    return fmt::format("{} ({}{})", counted(files.count, noun), files.count == 1 ? "" : "such as ",
                       printable(files.first, kMaxShownName));
  };
  std::string skipped = pictures.count > 0 ? text(pictures, "picture") : "";
  if (others.count > 0) skipped += (skipped.empty() ? "" : " and ") + text(others, "other file");
  return {NoteId::other_files,
          fmt::format("{}: the program takes {} and skips {}", printable(folder), text(taken, kind), skipped)};
}

std::optional<std::string> find_one_volume(std::span<const std::string> inputs) {
  if (inputs.size() < 2) return std::nullopt;
  const std::string folder = inputs.front().substr(0, inputs.front().find_last_of('/') + 1);
  std::unordered_set<std::string> names;
  std::unordered_set<std::string> extensions;
  for (const std::string& input : inputs) {
    if (!input.starts_with(folder) || !is_file_name(input)) return std::nullopt;
    std::string name = input.substr(folder.size());
    if (name.find('/') != std::string::npos) return std::nullopt;
    extensions.insert(fs::path(name).extension().string());
    if (!names.insert(std::move(name)).second) return std::nullopt;
  }
  std::vector<std::string> beside;  // files that could belong to the same volume
  const auto listed = files::visit_folder(folder, [&](const std::string& name, const fs::directory_entry& entry) {
    std::error_code none;
    if (!entry.is_directory(none) && extensions.contains(fs::path(name).extension().string())) beside.push_back(name);
  });
  if (!listed) return std::nullopt;
  const bool is_any_missing = std::ranges::count_if(beside, [&](const std::string& name) {
                                return names.contains(name);
                              }) != static_cast<std::ptrdiff_t>(names.size());
  if (is_any_missing) return std::nullopt;
  if (volume_io::has_picture_extension(inputs.front())) {
    const std::vector<Sequence> sequences = sequences_of(inputs);
    if (sequences.size() != 1) return std::nullopt;
    const auto pattern = files::FramePattern::parse(sequences.front().pattern.substr(folder.size()));
    if (!pattern || !*pattern) return std::nullopt;
    const auto matching =
        std::ranges::count_if(beside, [&](const std::string& name) { return (*pattern)->match(name).has_value(); });
    const bool are_all = matching == static_cast<std::ptrdiff_t>(names.size());
    return are_all && volume_io::is_slice_stack(sequences.front().pattern, Context())
               ? std::optional(sequences.front().pattern)
               : std::nullopt;
  }
  const std::string path = folder.empty() ? "." : folder;
  return beside.size() == names.size() && volume_io::is_volume_folder(path, Context()) ? std::optional(path)
                                                                                       : std::nullopt;
}

std::vector<FrameRun> gaps_of(const FrameRange& range, std::span<const Frame> frames) {
  std::vector<std::int64_t> missing;
  auto frame = frames.begin();
  for (const std::int64_t number : range.numbers()) {
    if (frame != frames.end() && frame->number == number) {
      ++frame;
    } else {
      missing.push_back(number);
    }
  }
  return runs_of(missing);
}

Result<Frames> find_frames(std::span<const std::string> given, const std::optional<FrameRange>& range,
                           bool pictures_are_frames) {
  const std::vector<std::string> inputs = without_sample_files(given);
  if (inputs.empty()) return fail(ErrorCode::usage, "expected an input, found none");
  const std::string& input = inputs.front();
  const auto choose = [&](Result<FoundFrames> found) -> Result<Frames> {
    if (!found) return tl::unexpected(std::move(found.error()));
    return chosen_frames(std::move(*found), range,
                         inputs.size() == 1 ? input : fmt::format("{} and {} more", input, inputs.size() - 1));
  };
  if (inputs.size() > 1) {
    if (!pictures_are_frames) TRY(check_slices(inputs));
    return choose(listed_files(inputs));
  }
  std::error_code none;
  const fs::file_status status = is_file_name(input) ? fs::status(input, none) : fs::file_status();
  const bool is_folder = fs::is_directory(status);
  const bool is_stack = !pictures_are_frames && volume_io::is_slice_stack(input, Context());
  if (is_folder && !is_stack && !volume_io::is_volume_folder(input, Context())) return choose(files_of_folder(input));
  if (!fs::exists(status) && !is_stack && !volume_io::find_inner_path(input)) {
    const auto pattern = TRY(files::FramePattern::parse(input));
    if (pattern && !is_file_name(input)) return without_files(*pattern, range, input);
    if (pattern) return choose(matching_files(*pattern, range, input));
  }
  if (range) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected a sequence for the frames {}, found one input", printable(input),
                            text_of(range->runs(), kShownRuns)),
                "write {} or {:04} where the input's name has the frame number, for example smoke_{:04}.vdb");
  }
  const std::int64_t number = is_file_name(input) ? trailing_number(input).value_or(1) : 1;
  return Frames{{{number, input, {}}}, {}, {}};
}

}  // namespace isoextract::batch
