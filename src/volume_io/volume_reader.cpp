#include "volume_io/volume_reader.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/allocation_error.hpp"
#include "base/printable.hpp"
#include "field/no_data.hpp"
#include "files/file_bytes.hpp"
#include "files/unpacked_files.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "volume_io/detail/grid_choice.hpp"
#include "volume_io/detail/slice_stack.hpp"
#include "volume_io/detail/volume_detect.hpp"

namespace isoextract::volume_io {
namespace {

// Rejects options that have no effect on this format.
Result<void> check_options(const std::string& input, const FormatDescription& about, const ReadOptions& options) {
  if (options.raw && !about.needs_layout) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: dims, type, byte order and bytes to skip apply to raw files only; this is {}", input,
                    about.id),
        about.prefix.empty() ? Hint(Remedy::set, Setting::input_format, "raw to read the bytes of any file") : Hint());
  }
  if (options.grid && !about.has_grids) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: a grid name applies to formats with named grids, such as VDB; this is {}", input, about.id),
        Hint{{Remedy::leave_out, Setting::grid, "this format has no named grids"},
             "if the input has the form FILE:/NAME, give only FILE"});
  }
  if (options.volume && !about.has_volumes) {
    return fail(ErrorCode::usage,
                fmt::format("{}: a volume number applies to formats with several volumes; this is {}", input, about.id),
                {Remedy::leave_out, Setting::volume, "this format has no numbered volumes"});
  }
  if (options.component && !about.has_components) {
    return fail(ErrorCode::usage,
                fmt::format("{}: a component applies to formats with several numbers per sample; this is "
                            "{}",
                            input, about.id),
                {Remedy::leave_out, Setting::component});
  }
  if (options.axis_order && !about.has_axis_order) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: an axis order applies to NumPy arrays and raw files, which do not state it; this is {}", input,
                    about.id),
        {Remedy::leave_out, Setting::axis_order});
  }
  if (options.level && !about.has_levels) {
    return fail(ErrorCode::usage,
                fmt::format("{}: a level applies to formats with several resolutions, such as OME-Zarr; this is {}",
                            input, about.id),
                {Remedy::leave_out, Setting::level});
  }
  if (about.needs_layout && !options.raw) {
    return fail(ErrorCode::usage, fmt::format("{}: a raw file does not state its dimensions and sample type", input),
                {Remedy::give, Setting::raw_layout});
  }
  if (options.spacing) {
    for (int axis = 0; axis < 3; ++axis) {
      const double value = (*options.spacing)[axis];
      if (!(std::isfinite(value) && value > 0)) {
        return fail(ErrorCode::usage, fmt::format("the spacing: expected numbers greater than 0, found {}", value));
      }
    }
  }
  if (options.origin && !(std::isfinite(options.origin->x + options.origin->y + options.origin->z))) {
    return fail(ErrorCode::usage, fmt::format("the origin: expected finite numbers, found {}, {}, {}",
                                              options.origin->x, options.origin->y, options.origin->z));
  }
  return {};
}

// A file or folder with the options for it; the path within a file, of FILE.h5:/PATH, is a grid's name.
struct Located {
  std::string input;
  ReadOptions options;
};

// Returns the input's file, unpacked if it is compressed or an archive.
Result<Located> locate(const std::string& input, const ReadOptions& options, const Context& context) {
  Located located{input, options};
  const auto inner = find_inner_path(input);
  if (inner) located.input = input.substr(0, *inner);
  if (const auto marked = folder_of_marker(located.input, context)) located.input = *marked;
  if (!is_named_by_prefix(input)) located.input = TRY(unpack_for_volumes(located.input, options, context));
  if (!inner) return located;
  std::string grid = input.substr(*inner + 1);
  if (options.grid && *options.grid != grid) {
    return fail(ErrorCode::usage,
                fmt::format("{}: the input names the grid '{}', but the option names the grid '{}'", located.input,
                            printable(grid), printable(*options.grid)),
                {Remedy::leave_out, Setting::grid});
  }
  located.options.grid = std::move(grid);
  return located;
}

// Returns whether a plug-in for particles has the same id as this format.
bool is_shared_id(const FormatDescription& about) {
  if (!about.is_plugin) return false;
  const auto tables =
      plugin_host::find_plugin_tables(plugin_host::plugin_folders(), plugin_host::kParticlePlugins.name_start);
  return std::ranges::find(tables, about.id, &plugin_host::PluginTable::id) != tables.end();
}

// Detects the format and calls work(detected, located), which returns a Result. Catches exceptions of libraries.
template <class F>
auto with_format(const std::string& input, const ReadOptions& options, const Context& context, F&& work)
    -> decltype(work(DetectedFormat(), Located())) {
  try {
    const auto located = TRY(locate(input, options, context));
    const auto detected = TRY(detect_format(located.input, located.options, context));
    TRY(check_options(files::input_label(located.input), detected.format->about(), located.options));
    return work(detected, located);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(files::input_label(input) + ": not enough memory to read it"));
  } catch (const std::exception& error) {
    return fail(ErrorCode::input, fmt::format("{}: {}", files::input_label(input), error.what()));
  }
}

}  // namespace

std::optional<std::size_t> find_inner_path(const std::string& input) {
  const std::size_t colon = input.rfind(":/");
  if (colon == std::string::npos || colon == 0) return std::nullopt;
  std::error_code none;
  if (std::filesystem::exists(input, none) || !std::filesystem::exists(input.substr(0, colon), none)) {
    return std::nullopt;
  }
  return colon;
}

bool is_volume_folder(const std::filesystem::path& path, const Context& context) {
  return std::ranges::any_of(volume_formats(),
                             [&](const VolumeFormat* format) { return format->probe_folder(path, context); });
}

bool is_slice_stack(const std::string& input, const Context& context) {
  return format_of_stack(input, context) != nullptr;
}

Result<bool> is_certainly_volume(const std::string& input, const ReadOptions& options, const Context& context) {
  if (is_named_by_prefix(input) || options.raw) return true;
  try {
    const VolumeFormat* format = options.format ? find_volume_format(*options.format) : nullptr;
    if (options.format && (format == nullptr || !is_shared_id(format->about()))) return format != nullptr;
    const auto located = TRY(locate(input, options, context));
    if (format != nullptr) {
      const auto detected = detect_format(located.input, {}, context);
      return detected && detected->format == format;
    }
    return has_volume_content(located.input, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(files::input_label(input) + ": not enough memory to read it"));
  } catch (const std::exception& error) {
    return fail(ErrorCode::input, fmt::format("{}: {}", files::input_label(input), error.what()));
  }
}

Result<std::vector<GridInfo>> list_grids(const std::string& input, const ReadOptions& options, const Context& context) {
  return with_format(input, options, context, [&](const DetectedFormat& detected, const Located& at) {
    auto grids = detected.format->list(at.input, at.options, context);
    if (!grids || !find_inner_path(input)) return grids;
    // The path names the only grid of interest.
    const auto is_other = [&](const GridInfo& grid) { return !grid.matches_name(*at.options.grid); };
    if (!std::ranges::all_of(*grids, is_other)) std::erase_if(*grids, is_other);
    return grids;
  });
}

Result<std::string> grid_label(const std::string& input, const ReadOptions& options, const Context& context) {
  const auto grids = TRY(list_grids(input, options, context));
  const auto located = TRY(locate(input, options, context));
  const std::optional<std::string>& wanted = located.options.grid;
  const auto chosen = choose_grid(files::input_label(input), grids, wanted);
  if (chosen) return (grids)[*chosen].label;
  // Plug-ins read grids that are not scalar, and parts of vector grids.
  for (const GridInfo& grid : grids) {
    if (grid.plugin.empty()) continue;
    const bool is_part = std::ranges::find(grid.parts, *wanted) != grid.parts.end();
    if (!is_part && !grid.matches_name(*wanted)) continue;
    if (grid.plugin_is_missing) {
      return fail(
          ErrorCode::unavailable,
          fmt::format("{}: the grid '{}' has values of type {}; the plug-in for {} reads them, but it is missing",
                      files::input_label(input), grid.label, grid.type, grid.plugin),
          "install the plug-in, or set the environment variable ISOEXTRACT_PLUGINS to its folder");
    }
    if (is_part || grid.parts.empty()) return *wanted;
    return fail(ErrorCode::input, chosen.error().message,
                Hint(Remedy::choose, Setting::grid, fmt::format("\n  {}", fmt::join(grid.parts, "\n  "))));
  }
  return tl::unexpected(chosen.error());
}

Result<FormatDescription> format_of(const std::string& input, const ReadOptions& options, const Context& context) {
  return with_format(input, options, context,
                     [](const DetectedFormat& detected, const Located& /*at*/) -> Result<FormatDescription> {
                       return detected.format->about();
                     });
}

Result<std::uint64_t> count_volumes(const std::string& input, const ReadOptions& options, const Context& context) {
  ReadOptions all = options;
  all.volume.reset();
  return with_format(input, all, context,
                     [&](const DetectedFormat& detected, const Located& at) -> Result<std::uint64_t> {
                       if (!detected.format->about().has_volumes) return 1;
                       const auto grids = TRY(detected.format->list(at.input, at.options, context));
                       if (grids.empty()) return 1;
                       if (at.options.grid) {
                         const auto chosen = TRY(choose_grid(files::input_label(at.input), grids, at.options.grid));
                         return (grids)[chosen].volumes;
                       }
                       return std::ranges::max(grids, {}, &GridInfo::volumes).volumes;
                     });
}

Result<std::vector<std::filesystem::path>> list_input_files(const std::string& input, const ReadOptions& options,
                                                            const Context& context) {
  auto paths = with_format(input, options, context, [&](const DetectedFormat& detected, const Located& at) {
    return detected.format->files(at.input, at.options, context);
  });
  if (paths) std::ranges::transform(*paths, paths->begin(), files::packed_source);
  return paths;
}

Result<std::vector<files::FilePart>> list_input_parts(const std::string& input, const ReadOptions& options,
                                                      const Context& context) {
  auto parts = with_format(input, options, context, [&](const DetectedFormat& detected, const Located& at) {
    return detected.format->parts(at.input, at.options, context);
  });
  for (std::size_t i = 0; parts && i < parts->size(); ++i) {
    files::FilePart& part = (*parts)[i];
    std::filesystem::path source = files::packed_source(part.path);
    if (source != part.path) part = {std::move(source), {}};
  }
  return parts;
}

Result<field::ScalarField> read_volume(const std::string& input, const ReadOptions& options, const Context& context) {
  return with_format(input, options, context, [&](const DetectedFormat& detected, const Located& at) {
    auto field = detected.format->open(at.input, at.options, context);
    if (!field) return field;
    if (!detected.note.empty()) field->notes.insert(field->notes.begin(), {NoteId::format_not_by_name, detected.note});
    field->source = files::input_label(input);
    if (options.kind) field->kind = *options.kind;
    const bool is_sparse = std::holds_alternative<field::SparseSamples>(field->samples);
    if (!options.no_data || (is_sparse && options.no_data_for_dense_only)) return field;
    if (auto marked = field::mark_no_data(*field, *options.no_data, context); !marked) {
      field = tl::unexpected(std::move(marked.error()));
    }
    return field;
  });
}

Result<void> check_mapping_intact(const field::ScalarField& field) {
  const auto* dense = std::get_if<field::DenseSamples>(&field.samples);
  if (dense == nullptr || !dense->lost()) return {};
  if (dense->is_lost_on_disk != nullptr) {
    return fail(ErrorCode::input,
                field.source + ": the disk lost samples of the temporary file, which it could not write or read",
                "set the environment variable TMPDIR to a folder on another disk");
  }
  return fail(ErrorCode::input, field.source + ": the file became shorter, or reading it failed, during the run",
              "run again when no other program writes to the file, or on a copy of it");
}

}  // namespace isoextract::volume_io
