#include "batch/output_names.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "batch/detail/input_names.hpp"
#include "batch/detail/piece_names.hpp"
#include "batch/manifest.hpp"
#include "batch/output_template.hpp"
#include "convert/output_checks.hpp"
#include "files/file_bytes.hpp"
#include "files/frame_pattern.hpp"
#include "files/location_keys.hpp"
#include "files/name_parts.hpp"
#include "files/output_file.hpp"
#include "files/unpacked_files.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastFrameDigits = 4;  // in names made here

std::string label_of_source(const OutputSource& source) {
  if (source.alone) return printable(source.input);
  std::string label = fmt::format("frame {} ({}", source.frame, printable(source.input));
  if (!source.grid.empty()) label += fmt::format(", grid {}", printable(source.grid));
  return label + ")";
}

// Who reads or writes a file: the conversion of a source, or `other`.
struct FileUse {
  const OutputSource* source = nullptr;
  const NamedFile* other = nullptr;
};

std::string reader_text(const FileUse& use) {
  if (use.source == nullptr) return use.other->what;
  return use.source->alone ? "is the input" : "is the input of " + label_of_source(*use.source);
}

std::string mesh_text(const OutputSource& source) {
  return source.alone ? "the mesh" : "the mesh of " + label_of_source(source);
}

// All files of a run in one set, by their place on disk.
class FileUses {
 public:
  explicit FileUses(files::LocationKeys& places) : places_(places) {}

  void add_read(const fs::path& file, const FileUse& use) { readers_.try_emplace(places_.key(file), use); }

  // Adds a file to write. Fails with ErrorCode::usage if it is read, already written, or named like a manifest.
  Result<void> add_written(const fs::path& file, const FileUse& use) {
    const std::string shown = printable(files::output_label(file));
    const Hint hint = use.source != nullptr ? Hint(Remedy::change, Setting::output_name) : use.other->hint;
    if (is_manifest_name(file.filename().string())) {
      return fail(ErrorCode::usage, fmt::format("{}: only the manifest of a batch may have this name", shown), hint);
    }
    const std::string key = places_.key(file);
    if (const auto reader = readers_.find(key); reader != readers_.end()) {
      return fail(ErrorCode::usage, over_read(shown, use, reader_text(reader->second)), hint);
    }
    const auto [writer, fresh] = writers_.try_emplace(key, use);
    const bool is_lost = !files::is_same_output(file, file);  // a device such as /dev/null
    return fresh || is_lost ? Result<void>() : twice(shown, writer->second, use);
  }

 private:
  static std::string over_read(const std::string& shown, const FileUse& use, const std::string& reader) {
    constexpr std::string_view kKept = "it is not overwritten";
    if (use.source == nullptr) {
      return fmt::format("{}: {} needs another name: this {}; {}", shown, use.other->what, reader, kKept);
    }
    if (use.source->alone) return fmt::format("{}: this {}; {}", shown, reader, kKept);
    return fmt::format("{}: {} needs another output name: this {}; {}", shown, label_of_source(*use.source), reader,
                       kKept);
  }

  static tl::unexpected<Error> twice(const std::string& shown, const FileUse& first, const FileUse& second) {
    if (second.source == nullptr) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: {} and {} would share this file", shown, second.other->what,
                              first.source != nullptr ? mesh_text(*first.source) : first.other->what),
                  second.other->hint);
    }
    const std::string label = label_of_source(*second.source);
    return fail(ErrorCode::usage,
                first.source == second.source ? fmt::format("{}: two outputs of {} would share this file", shown, label)
                                              : fmt::format("{}: {} and {} would both write this file", shown,
                                                            label_of_source(*first.source), label),
                {{Remedy::change, Setting::output_name,
                  "with {frame:04}, {}, {stem}, {grid} or {iso} in it, to tell the outputs apart"},
                 {Remedy::use, Setting::animation},
                 {Remedy::use, Setting::masks}});
  }

  files::LocationKeys& places_;
  std::unordered_map<std::string, FileUse> readers_;
  std::unordered_map<std::string, FileUse> writers_;
};

// Returns a template that tells the files in a folder apart.
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
    digits = std::max(digits, files::frame_digits(source.frame < 0 ? -source.frame : source.frame, 0).size());
  }
  return fmt::format("{{stem}}{}{}.{}", with_frame ? fmt::format("_{{frame:0{}}}", digits) : "",
                     with_grid ? "_{grid}" : "", extension);
}

Result<OutputTemplate> template_of(std::span<const OutputSource> sources, const std::optional<std::string>& output,
                                   std::string_view extension) {
  if (!output) return OutputTemplate::parse(name_in_folder(sources, extension));
  if (output->empty()) return fail(ErrorCode::usage, "expected the name of an output, found an empty one");
  std::error_code none;
  if (fs::is_directory(*output, none)) {
    const std::string slash = output->ends_with('/') ? "" : "/";
    return OutputTemplate::parse(files::escaped_name(*output) + slash + name_in_folder(sources, extension));
  }
  return OutputTemplate::parse(output->ends_with('/') ? *output + name_in_folder(sources, extension) : *output);
}

Result<void> check_words(const OutputSource& source, const OutputTemplate& names, mesh_io::MeshFormat format) {
  if (names.uses(OutputWord::grid) && source.grid.empty()) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected the name of a grid for {{grid}} in the output name, found none",
                            label_of_source(source)),
                "leave {grid} out; or choose a grid by its name, if the format has named grids");
  }
  if (names.uses(OutputWord::step) && !source.step) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected the number of a time step for {{step}} in the output name, found none",
                            label_of_source(source)),
                "put {frame} or {stem} into the name instead");
  }
  const mesh_io::MeshFormatInfo& info = mesh_io::mesh_format_info(format);
  const bool are_labels = !source.isos.empty() && source.isos.front().is_label();
  const bool all_labels = are_labels && source.isos.front().is_label_set();
  const bool by_label = names.uses(OutputWord::label) || names.uses(OutputWord::name);
  if (by_label && !are_labels) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected labels for {{label}} or {{name}} in the output name, found none",
                            label_of_source(source)),
                "put {iso} into the name instead");
  }
  const bool tells_apart = by_label || names.uses(OutputWord::iso);
  // Counts a label name as one label: the conversion refuses a second label with this name.
  const bool is_one =
      source.isos.empty() || (source.isos.size() == 1 && (!all_labels || source.isos.front().is_label_name()));
  if (names.uses(OutputWord::piece) && !is_one && !tells_apart) {
    return fail(ErrorCode::usage,
                fmt::format("{}: bodies of several surfaces would have the same file names", label_of_source(source)),
                "put {iso} into the name as well");
  }
  if (all_labels && names.uses(OutputWord::iso)) {
    return fail(ErrorCode::usage,
                fmt::format("{}: {{iso}} in the output name does not work with all labels: the run chooses the file "
                            "names before it reads the labels",
                            label_of_source(source)),
                "put {label} or {name} into the name instead, or write all into a glb");
  }
  if (info.can_hold_several_meshes) return {};
  if (!source.more_grids.empty() && !names.uses(OutputWord::grid)) {
    return fail(ErrorCode::usage,
                fmt::format("{}: one {} file holds one surface, found {} grids", label_of_source(source), info.name,
                            source.more_grids.size() + 1),
                "put {grid} into the name to get a file for each, or write all into a glb");
  }
  if (is_one || tells_apart) return {};
  if (all_labels) {
    return fail(ErrorCode::usage,
                fmt::format("{}: one {} file holds one surface, but {} can give several", label_of_source(source),
                            info.name, convert::text_of(source.isos.front())),
                "put {label} or {name} into the name to get a file for each, or write all into a glb");
  }
  std::vector<std::string_view> others;
  for (const mesh_io::MeshFormatInfo& other : mesh_io::mesh_formats()) {
    if (other.can_hold_several_meshes) others.push_back(other.name);
  }
  return fail(ErrorCode::usage,
              fmt::format("{}: one {} file holds one surface, found {} {}", label_of_source(source), info.name,
                          source.isos.size(), source.isos.front().is_label() ? "labels" : "iso values"),
              {{Remedy::set, Setting::mesh_format, fmt::format("{}", fmt::join(others, ", "))},
               {Remedy::change, Setting::output_name, "with {iso} in it, to get a file for each"}});
}

OutputFiles files_of(const OutputSource& source, const OutputTemplate& names) {
  const bool by_grid = names.uses(OutputWord::grid) && !source.more_grids.empty();
  std::vector<std::string> grids{source.grid};
  if (by_grid) grids.insert(grids.end(), source.more_grids.begin(), source.more_grids.end());
  OutputFiles files;
  for (const std::string& grid : grids) {
    const auto only = by_grid ? std::optional(grid) : std::nullopt;
    OutputWords words{stem_of(source.input), source.frame, grid, {}, source.step.value_or(0)};
    if (!names.uses(OutputWord::iso)) {
      files.push_back({names.expand(words), source.isos, only});
      continue;
    }
    for (const convert::IsoChoice& iso : source.isos) {
      words.iso = file_name_part(iso);
      files.push_back({names.expand(words), {iso}, only});
    }
  }
  return files;
}

// Refuses a .gltf file with the name of its data file.
Result<void> check_data_file(const convert::OutputFileJob& output, mesh_io::MeshFormat format,
                             files::LocationKeys& places) {
  const std::vector<fs::path> files = convert::mesh_files(output, format);
  if (files.size() < 2 || places.key(files[0]) != places.key(files[1])) return {};
  const std::string_view name = mesh_io::mesh_format_info(format).name;
  return fail(ErrorCode::usage,
              fmt::format("{}: a {} file has its data in a {} file beside it, which would overwrite this one",
                          printable(output.path), name, files[1].extension().string()),
              {Remedy::change, Setting::output_name,
               fmt::format("that ends in .{}, such as {}", name,
                           printable(fs::path(output.path).replace_extension(name).string()))});
}

// Checks the files whose names contain {piece}.
Result<void> check_piece_files(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                               mesh_io::MeshFormat format, const OtherFiles& others, files::LocationKeys& places) {
  PieceNames names;
  bool any = false;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const convert::OutputFileJob& output : outputs[i]) {
      if (output.path.find(convert::kPiecePlaceholder) == std::string::npos) continue;
      any = true;
      for (const fs::path& file : convert::mesh_files(output, format)) {
        if (file.string().find(convert::kPiecePlaceholder) == std::string::npos) {
          return fail(ErrorCode::usage, fmt::format("{}: all bodies would share this file", printable(file.string())),
                      "put {piece} before the extension");
        }
        const auto first = names.add(places.by_name(file), i);
        if (!first) continue;
        if (*first == i) {
          return fail(ErrorCode::usage,
                      fmt::format("{}: bodies of two surfaces may get the same file name", printable(file.string())),
                      "put a character other than a digit before and behind {piece}");
        }
        return fail(ErrorCode::usage,
                    fmt::format("{}: bodies of {} and of {} may get the same file name", printable(file.string()),
                                label_of_source(sources[*first]), label_of_source(sources[i])),
                    "put {frame} into the name, and a character that is not a digit before and behind {piece}");
      }
    }
  }
  for (std::size_t i = 0; any && i < others.written.size(); ++i) {
    const auto writer = names.find_collision(places.by_name(others.written[i].path));
    if (!writer) continue;
    return fail(
        ErrorCode::usage,
        fmt::format("{}: a body of {} may get this file name, which is the name of {}",
                    printable(others.written[i].path), label_of_source(sources[*writer]), others.written[i].what),
        others.written[i].hint);
  }
  for (std::size_t i = 0; any && i < sources.size(); ++i) {
    if (!is_file_name(sources[i].input) || files::is_standard_input(sources[i].input)) continue;
    const auto writer = names.find_collision(places.by_name(sources[i].input));
    if (!writer) continue;
    const std::string reader =
        sources[i].alone ? "this is the input" : "this is the input of " + label_of_source(sources[i]);
    return fail(ErrorCode::usage,
                fmt::format("{}: {}, and the mesh of a body of {} may get the same name; the program does not "
                            "overwrite its input",
                            printable(sources[i].input), reader, label_of_source(sources[*writer])),
                {Remedy::change, Setting::output_name});
  }
  return {};
}

}  // namespace

Result<std::vector<OutputFiles>> name_outputs_unchecked(std::span<const OutputSource> sources,
                                                        const std::optional<std::string>& output,
                                                        mesh_io::MeshFormat format, std::string_view extension) {
  const auto names =
      TRY(template_of(sources, output, extension.empty() ? mesh_io::mesh_format_info(format).name : extension));
  std::vector<OutputFiles> outputs;
  outputs.reserve(sources.size());
  for (const OutputSource& source : sources) {
    TRY(check_words(source, names, format));
    outputs.push_back(files_of(source, names));
  }
  return outputs;
}

Result<std::vector<OutputFiles>> name_outputs(std::span<const OutputSource> sources,
                                              const std::optional<std::string>& output, mesh_io::MeshFormat format,
                                              std::string_view extension, const OtherFiles& others) {
  auto outputs = name_outputs_unchecked(sources, output, format, extension);
  if (!outputs) return outputs;
  TRY(check_outputs(sources, *outputs, format, others));
  return outputs;
}

Result<void> check_outputs(std::span<const OutputSource> sources, std::span<const OutputFiles> outputs,
                           mesh_io::MeshFormat format, const OtherFiles& others) {
  files::LocationKeys places;
  FileUses uses(places);
  for (const NamedFile& file : others.read) uses.add_read(file.path, {nullptr, &file});
  for (const OutputSource& source : sources) {
    // "-" means standard input as an input, but standard output as an output.
    if (is_file_name(source.input) && source.input != "-") uses.add_read(source.input, {&source, nullptr});
  }
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const convert::OutputFileJob& output : outputs[i]) {
      TRY(check_data_file(output, format, places));
      for (const fs::path& file : convert::mesh_files(output, format)) {
        TRY(uses.add_written(file, {&sources[i], nullptr}));
      }
    }
  }
  for (const NamedFile& file : others.written) {
    TRY(uses.add_written(file.path, {nullptr, &file}));
  }
  return check_piece_files(sources, outputs, format, others, places);
}

std::string stem_of(const std::string& input) {
  if (files::is_standard_input(input)) return "stdin";
  if (!is_file_name(input)) {
    const std::string name = input.substr(input.find(':') + 1);
    return name.substr(0, name.find('?'));
  }
  std::string name = fs::path(input).filename().string();
  if (name.empty()) name = fs::path(input).parent_path().filename().string();  // of a folder with a slash at the end
  // The name of a stack of slices is what its files have in common.
  const auto pattern = files::FramePattern::parse(name);
  if (pattern && *pattern && !files::is_there(input)) {
    const std::string& prefix = (*pattern)->prefix();
    const std::size_t last = prefix.find_last_not_of("_-. ");
    if (last != std::string::npos) return prefix.substr(0, last + 1);
  }
  return fs::path(files::name_without_packing(name)).stem().string();
}

}  // namespace isoextract::batch
