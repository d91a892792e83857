#include "batch/output_names.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "batch/detail/input_names.hpp"
#include "batch/detail/name_parts.hpp"
#include "batch/detail/piece_names.hpp"
#include "batch/frame_pattern.hpp"
#include "batch/output_template.hpp"
#include "convert/output_checks.hpp"
#include "files/file_bytes.hpp"
#include "files/output_file.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastFrameDigits = 4;  // of names that are made here

// Texts that are equal where what is written to two paths would come to one place, as files::same_place() has it, each
// found once.
class PlaceKeys {
 public:
  std::string key(const fs::path& path) {
    if (path == "-") return "-";
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0) return fmt::format("{}:{}", status.st_dev, status.st_ino);
    return by_name(path);
  }

  // Of a path whose file need not be there.
  std::string by_name(const fs::path& path) {
    return fmt::format("{}/{}", folder(path.parent_path().string()), path.filename().string());
  }

 private:
  const std::string& folder(const std::string& name) {
    const auto [known, fresh] = folders_.try_emplace(name);
    if (fresh) {
      std::error_code none;
      const fs::path absolute = fs::absolute(name.empty() ? "." : name, none);
      fs::path canonical = fs::weakly_canonical(absolute, none);
      if (none) canonical = absolute.lexically_normal();
      if (!canonical.has_filename()) canonical = canonical.parent_path();  // a slash at its end
      known->second = canonical.string();
    }
    return known->second;
  }

  std::unordered_map<std::string, std::string> folders_;
};

std::string label_of_source(const OutputSource& source) {
  std::string label = fmt::format("frame {} ({}", source.frame, printable(source.input));
  if (!source.grid.empty()) label += fmt::format(", grid {}", printable(source.grid));
  return label + ")";
}

// What tells the names in a folder apart.
std::string name_in_folder(std::span<const OutputSource> sources, std::string_view extension) {
  std::unordered_map<std::string, std::int64_t> frame_of_stem;
  std::map<std::pair<std::int64_t, std::string>, const std::string*> grid_of_frame;
  bool with_frame = false;
  bool with_grid = false;
  std::size_t digits = kLeastFrameDigits;
  for (const OutputSource& source : sources) {
    const std::string stem = stem_of(source.input);
    const auto frame = frame_of_stem.try_emplace(stem, source.frame).first;
    with_frame = with_frame || frame->second != source.frame;
    const auto grid = grid_of_frame.try_emplace({source.frame, source.input}, &source.grid).first;
    with_grid = with_grid || *grid->second != source.grid;
    digits = std::max(digits, frame_digits(source.frame < 0 ? -source.frame : source.frame, 0).size());
  }
  return fmt::format("{{stem}}{}{}.{}", with_frame ? fmt::format("_{{frame:0{}}}", digits) : "",
                     with_grid ? "_{grid}" : "", extension);
}

Result<OutputTemplate> template_of(std::span<const OutputSource> sources, const std::optional<std::string>& output,
                                   std::string_view extension) {
  if (!output) return OutputTemplate::parse(name_in_folder(sources, extension));
  if (output->empty()) return fail(ErrorKind::usage, "expected the name of an output, found an empty one");
  std::error_code none;
  if (fs::is_directory(*output, none)) {
    const std::string slash = output->ends_with('/') ? "" : "/";
    return OutputTemplate::parse(escaped_name(*output) + slash + name_in_folder(sources, extension));
  }
  return OutputTemplate::parse(output->ends_with('/') ? *output + name_in_folder(sources, extension) : *output);
}

Result<void> check_words(const OutputSource& source, const OutputTemplate& names, meshes::MeshFormat format) {
  if (names.uses(OutputWord::grid) && source.grid.empty()) {
    return fail(ErrorKind::usage,
                fmt::format("{}: expected a grid to name the output after, found none chosen", label_of_source(source)),
                "choose the grid by its name");
  }
  const meshes::MeshFormatInfo& info = meshes::mesh_format_info(format);
  const bool all_labels = !source.isos.empty() && source.isos.front().kind == convert::IsoChoice::Kind::all_labels;
  if (names.uses(OutputWord::piece) && (source.isos.size() > 1 || all_labels) && !names.uses(OutputWord::iso)) {
    return fail(ErrorKind::usage,
                fmt::format("{}: pieces of several surfaces would have the same names", label_of_source(source)),
                "put {iso} into the name as well");
  }
  if (all_labels && names.uses(OutputWord::iso)) {
    return fail(ErrorKind::usage,
                fmt::format("{}: which labels there are is known once they are read", label_of_source(source)),
                "list the labels, or write all into a glb");
  }
  if ((source.isos.size() < 2 && !all_labels) || info.holds_several_meshes || names.uses(OutputWord::iso)) return {};
  std::vector<std::string_view> others;
  for (const meshes::MeshFormatInfo& other : meshes::mesh_formats()) {
    if (other.holds_several_meshes) others.push_back(other.name);
  }
  return fail(ErrorKind::usage,
              fmt::format("{}: one {} file holds one surface, found {} {}", label_of_source(source), info.name,
                          source.isos.size(), source.isos.front().is_label() ? "labels" : "iso values"),
              {Remedy::one_file_per_surface, fmt::format("{}", fmt::join(others, ", "))});
}

OutputFiles files_of(const OutputSource& source, const OutputTemplate& names) {
  OutputWords words{stem_of(source.input), source.frame, source.grid, {}};
  if (!names.uses(OutputWord::iso)) return {{names.expand(words), source.isos}};
  OutputFiles files;
  for (const convert::IsoChoice& iso : source.isos) {
    words.iso = name_part_of(iso);
    files.push_back({names.expand(words), {iso}});
  }
  return files;
}

// Files whose names have a place for the numbers of pieces.
Result<void> check_piece_files(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                               meshes::MeshFormat format, PlaceKeys& places) {
  PieceNames names;
  bool any = false;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const convert::OutputFileJob& output : outputs[i]) {
      if (output.path.find(convert::kPieceWord) == std::string::npos) continue;
      any = true;
      for (const fs::path& file : convert::mesh_files(output, format)) {
        const auto first = names.add(places.by_name(file), i);
        if (!first) continue;
        if (*first == i) {
          return fail(ErrorKind::usage,
                      fmt::format("{}: pieces of two surfaces may have one name", printable(file.string())),
                      "put something that is no digit before and behind {piece}");
        }
        return fail(ErrorKind::usage,
                    fmt::format("{}: pieces of {} and of {} may have one name", printable(file.string()),
                                label_of_source(sources[*first]), label_of_source(sources[i])),
                    "put something that is no digit before and behind {piece}, and {frame} into the name");
      }
    }
  }
  for (std::size_t i = 0; any && i < sources.size(); ++i) {
    if (!is_file_name(sources[i].input) || files::is_standard_input(sources[i].input)) continue;
    const auto writer = names.could_be(places.by_name(sources[i].input));
    if (!writer) continue;
    return fail(
        ErrorKind::usage,
        fmt::format("{}: a piece of {} may have this name, and it is the input of {}; it is not overwritten",
                    printable(sources[i].input), label_of_source(sources[*writer]), label_of_source(sources[i])),
        Remedy::other_output_name);
  }
  return {};
}

}  // namespace

Result<std::vector<OutputFiles>> name_outputs(std::span<const OutputSource> sources,
                                              const std::optional<std::string>& output, meshes::MeshFormat format,
                                              std::string_view extension) {
  const auto names =
      template_of(sources, output, extension.empty() ? meshes::mesh_format_info(format).name : extension);
  if (!names) return tl::unexpected(names.error());
  std::vector<OutputFiles> outputs;
  outputs.reserve(sources.size());
  for (const OutputSource& source : sources) {
    if (auto checked = check_words(source, *names, format); !checked) return tl::unexpected(checked.error());
    outputs.push_back(files_of(source, *names));
  }
  if (auto checked = check_outputs(sources, outputs, format); !checked) return tl::unexpected(checked.error());
  return outputs;
}

Result<void> check_outputs(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                           meshes::MeshFormat format) {
  PlaceKeys places;
  std::unordered_map<std::string, const OutputSource*> readers;
  for (const OutputSource& source : sources) {
    if (is_file_name(source.input)) readers.try_emplace(places.key(source.input), &source);
  }
  readers.erase("-");  // standard input is not standard output
  std::unordered_map<std::string, const OutputSource*> writers;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const convert::OutputFileJob& output : outputs[i]) {
      for (const fs::path& file : convert::mesh_files(output, format)) {
        const std::string key = places.key(file);
        if (const auto reader = readers.find(key); reader != readers.end()) {
          return fail(ErrorKind::usage,
                      fmt::format("{}: {} would write it, and it is the input of {}; it is not overwritten",
                                  printable(files::shown_output_name(file)), label_of_source(sources[i]),
                                  label_of_source(*reader->second)),
                      Remedy::other_output_name);
        }
        const auto [writer, fresh] = writers.try_emplace(key, &sources[i]);
        if (fresh) continue;
        const OutputSource& first = *writer->second;
        return fail(ErrorKind::usage,
                    &first == &sources[i]
                        ? fmt::format("{}: two outputs of {} would be this file",
                                      printable(files::shown_output_name(file)), label_of_source(first))
                        : fmt::format("{}: {} and {} would both write it", printable(files::shown_output_name(file)),
                                      label_of_source(first), label_of_source(sources[i])),
                    Remedy::number_outputs);
      }
    }
  }
  return check_piece_files(sources, outputs, format, places);
}

std::string stem_of(const std::string& input) {
  if (files::is_standard_input(input)) return "stdin";
  if (!is_file_name(input)) {
    const std::string name = input.substr(input.find(':') + 1);
    return name.substr(0, name.find('?'));
  }
  fs::path path = fs::path(input).filename();
  if (path.extension() == ".gz") path = path.stem();
  return path.stem().string();
}

}  // namespace isoextract::batch
