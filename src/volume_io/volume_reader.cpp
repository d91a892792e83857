#include "volume_io/volume_reader.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <new>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/allocation_error.hpp"
#include "field/no_data.hpp"
#include "files/file_bytes.hpp"
#include "volume_io/detail/grid_choice.hpp"
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
        {Remedy::leave_out, Setting::grid, "there is one volume in the file"});
  }
  if (options.volume && !about.has_volumes) {
    return fail(ErrorCode::usage,
                fmt::format("{}: a volume number applies to formats with several volumes; this is {}", input, about.id),
                {Remedy::leave_out, Setting::volume, "there is one volume in the file"});
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
    return fail(ErrorCode::usage, "the origin: expected finite numbers");
  }
  return {};
}

// Detects the format and calls work(detected), which returns a Result. Catches exceptions of libraries.
template <class F>
auto with_format(const std::string& input, const ReadOptions& options, const Context& context, F&& work)
    -> decltype(work(DetectedFormat())) {
  try {
    const auto detected = TRY(detect_format(input, options, context));
    TRY(check_options(files::input_label(input), detected.format->about(), options));
    return work(detected);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(files::input_label(input) + ": not enough memory to read it"));
  } catch (const std::exception& error) {
    return fail(ErrorCode::input, fmt::format("{}: {}", files::input_label(input), error.what()));
  }
}

}  // namespace

Result<bool> is_certainly_volume(const std::string& input, const ReadOptions& options, const Context& context) {
  if (is_named_by_prefix(input) || options.raw) return true;
  if (options.format) return find_volume_format(*options.format) != nullptr;
  try {
    return has_volume_content(input, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(files::input_label(input) + ": not enough memory to read it"));
  } catch (const std::exception& error) {
    return fail(ErrorCode::input, fmt::format("{}: {}", files::input_label(input), error.what()));
  }
}

Result<std::vector<GridInfo>> list_grids(const std::string& input, const ReadOptions& options, const Context& context) {
  return with_format(input, options, context,
                     [&](const DetectedFormat& detected) { return detected.format->list(input, options, context); });
}

Result<std::string> grid_label(const std::string& input, const ReadOptions& options, const Context& context) {
  const auto grids = TRY(list_grids(input, options, context));
  const auto chosen = choose_grid(files::input_label(input), grids, options.grid);
  if (chosen) return (grids)[*chosen].label;
  // Plug-ins read grids that are not scalar, and parts of vector grids.
  for (const GridInfo& grid : grids) {
    if (grid.plugin.empty()) continue;
    const bool is_part = std::ranges::find(grid.parts, *options.grid) != grid.parts.end();
    if (!is_part && !grid.matches_name(*options.grid)) continue;
    if (grid.plugin_is_missing) {
      return fail(
          ErrorCode::unavailable,
          fmt::format("{}: the grid '{}' has values of type {}; the plug-in for {} reads them, but it is missing",
                      files::input_label(input), grid.label, grid.type, grid.plugin),
          "install the plug-in, or set the environment variable ISOEXTRACT_PLUGINS to its folder");
    }
    if (is_part || grid.parts.empty()) return *options.grid;
    return fail(ErrorCode::input, chosen.error().message,
                Hint(Remedy::choose, Setting::grid, fmt::format("\n  {}", fmt::join(grid.parts, "\n  "))));
  }
  return tl::unexpected(chosen.error());
}

Result<FormatDescription> format_of(const std::string& input, const ReadOptions& options, const Context& context) {
  return with_format(input, options, context, [](const DetectedFormat& detected) -> Result<FormatDescription> {
    return detected.format->about();
  });
}

Result<std::uint64_t> count_volumes(const std::string& input, const ReadOptions& options, const Context& context) {
  ReadOptions all = options;
  all.volume.reset();
  return with_format(input, all, context, [&](const DetectedFormat& detected) -> Result<std::uint64_t> {
    if (!detected.format->about().has_volumes) return 1;
    const auto grids = TRY(detected.format->list(input, all, context));
    if (grids.empty()) return 1;
    if (options.grid) {
      const auto chosen = TRY(choose_grid(files::input_label(input), grids, options.grid));
      return (grids)[chosen].volumes;
    }
    return std::ranges::max(grids, {}, &GridInfo::volumes).volumes;
  });
}

Result<std::vector<std::filesystem::path>> list_input_files(const std::string& input, const ReadOptions& options,
                                                            const Context& context) {
  return with_format(input, options, context,
                     [&](const DetectedFormat& detected) { return detected.format->files(input, options, context); });
}

Result<std::vector<files::FilePart>> list_input_parts(const std::string& input, const ReadOptions& options,
                                                      const Context& context) {
  return with_format(input, options, context,
                     [&](const DetectedFormat& detected) { return detected.format->parts(input, options, context); });
}

Result<field::ScalarField> read_volume(const std::string& input, const ReadOptions& options, const Context& context) {
  return with_format(input, options, context, [&](const DetectedFormat& detected) {
    auto field = detected.format->open(input, options, context);
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
  return fail(ErrorCode::input, field.source + ": the file became shorter, or reading it failed, during the run",
              "run again when no other program writes to the file, or on a copy of it");
}

}  // namespace isoextract::volume_io
