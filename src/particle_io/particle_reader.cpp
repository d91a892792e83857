#include "particle_io/particle_reader.hpp"

#include <algorithm>
#include <array>
#include <exception>
#include <filesystem>
#include <functional>
#include <new>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/allocation_error.hpp"
#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "files/file_bytes.hpp"
#include "files/unpacked_files.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/particle_source.hpp"
#include "plugin_host/unpacked_input.hpp"

namespace isoextract::particle_io {
namespace {

const ParticleFormat* particles_by_id(std::string_view id) {
  for (const ParticleFormat* format : particle_formats()) {
    if (format->about().id == id) return format;
  }
  return nullptr;
}

// Skips formats that their content would have identified, if `only_tellable` is set.
const ParticleFormat* particles_by_extension(const std::filesystem::path& path, bool only_tellable) {
  const std::string name = to_lower(files::name_without_packing(path.filename().string()));
  for (const ParticleFormat* format : particle_formats()) {
    if (only_tellable && !format->about().needs_extension) continue;
    const auto claims = [&](const std::string& extension) { return name.ends_with(extension); };
    if (std::ranges::any_of(format->about().extensions, claims)) return format;
  }
  return nullptr;
}

const ParticleFormat* particles_by_content(const files::InputFile& file, const ParticleReadOptions& options) {
  std::array<std::byte, 2> start{};
  if (file.size() >= start.size()) must(file.read_at(0, start));
  const auto content = must(files::first_bytes(file, files::kStartBytes));
  for (const ParticleFormat* format : particle_formats()) {
    if (format->claims(file, {file.path(), content, files::is_gzip(start)}, options)) return format;
  }
  return nullptr;
}

// Returns null if the file does not appear to hold particles.
const ParticleFormat* format_of(const files::InputFile& file, const ParticleReadOptions& options, bool only_tellable) {
  if (options.format) {
    const ParticleFormat* format = particles_by_id(*options.format);
    if (format != nullptr) return format;
    throw Refused{{ErrorCode::usage,
                   fmt::format("{}: there is no particle format '{}'", file.name(), printable(*options.format, 40)),
                   {}}};
  }
  if (const ParticleFormat* format = particles_by_content(file, options)) return format;
  return particles_by_extension(file.path(), only_tellable);
}

[[noreturn]] void refuse_unknown(const files::InputFile& file) {
  std::string hint = "isoextract reads";
  for (const ParticleFormat* format : particle_formats()) {
    const ParticleFormatDescription& about = format->about();
    hint += fmt::format("\n  {:<7} {} ({})", about.id, about.title, fmt::join(about.extensions, " "));
  }
  const auto content = must(files::first_bytes(file, 16));
  throw InvalidParticleFile(
      fmt::format("not a particle format that isoextract reads; the file starts with '{}'", printable(content, 16)),
      Hint(hint));
}

// Rejects options that have no effect on this format.
void check_options(const files::InputFile& file, const ParticleFormatDescription& about,
                   const ParticleReadOptions& options) {
  const auto refuse = [&](std::string_view what, Hint hint) {
    throw Refused{
        {ErrorCode::usage, fmt::format("{}: {}; the format of this file is {}", file.name(), what, about.id), hint}};
  };
  if (options.frame && !about.has_frames) {
    refuse("only files with frames have a frame number",
           {Remedy::leave_out, Setting::volume, "the file has one frame"});
  }
  if (options.grid && !about.has_grids) {
    refuse("only files with grids have a grid name", {Remedy::leave_out, Setting::grid});
  }
  if (options.columns && !about.has_columns)
    refuse("only tables have columns for x, y and z to choose", "the file format defines x, y and z");
}

// Calls work(file), which may throw, and returns its result. Catches all exceptions. `skips_others`: returns an empty
// result for an archive without particle files, since other readers tell what it holds.
template <class F>
auto with_input(const std::string& input, const ParticleReadOptions& options, const Context& context, F&& work,
                bool skips_others = false) -> Result<decltype(work(std::declval<const files::InputFile&>()))> {
  const std::string name = files::input_label(input);
  try {
    const std::string path = must(plugin_host::unpacked_input(input, plugin_host::GzipFiles::keep, context));
    std::error_code none;
    if (path != input && std::filesystem::is_directory(path, none)) {
      if (skips_others && plugin_host::has_no_input(path, has_particle_extension)) return {};
      throw Refused{plugin_host::not_one_input(input, path, has_particle_extension)};
    }
    const auto file = must(files::InputFile::open(path, context));
    return work(file);
  } catch (const Refused& refused) {
    return tl::unexpected(refused.error);
  } catch (const TruncatedFrame& cut) {
    if (options.frame.value_or(0) == 0) return fail(ErrorCode::input, fmt::format("{}: {}", name, cut.what()));
    return fail(ErrorCode::input, fmt::format("{}: frame {} is incomplete: {}", name, *options.frame, cut.found),
                "convert the frames before it, or wait until the simulation has written it");
  } catch (const InvalidParticleFile& damaged) {
    return fail(ErrorCode::input, fmt::format("{}: {}", name, damaged.what()), damaged.hint);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(name + ": not enough memory to read it"));
  } catch (const std::exception& error) {
    return fail(ErrorCode::input, fmt::format("{}: {}", name, error.what()));
  }
}

const ParticleFormat& checked_format(const files::InputFile& file, const ParticleReadOptions& options) {
  const ParticleFormat* format = format_of(file, options, false);
  if (format == nullptr) refuse_unknown(file);
  check_options(file, format->about(), options);
  return *format;
}

void complete(ParticleFile& read, const ParticleFormat& format, const files::InputFile& file) {
  read.format = format.about().id;
  if (read.particles.label.empty()) read.particles.label = file.name();
}

}  // namespace

DescribedParticles ParticleFormat::describe(const files::InputFile& file, const ParticleReadOptions& options) const {
  return describe_by_reading(info(file, options), options,
                             [&](const ParticleReadOptions& all) { return read(file, all); });
}

DescribedParticles describe_by_reading(ParticleInfo info, const ParticleReadOptions& options,
                                       const std::function<ParticleFile(const ParticleReadOptions&)>& read) {
  ParticleReadOptions all = options;
  if (info.frames > 1 && !all.frame) all.frame = 0;
  all.attributes.clear();
  all.all_attributes = true;
  return {std::move(info), all.frame, read(all)};
}

std::string label_of_frame(const std::string& file, const ParticleReadOptions& options) {
  return options.frame ? fmt::format("{}, frame {}", file, *options.frame) : file;
}

std::uint64_t wanted_frame(const ParticleReadOptions& options) {
  const std::int64_t frame = options.frame.value_or(0);
  if (frame < 0) {
    throw InvalidParticleFile(fmt::format("there is no frame {}; frame numbers start at 0", frame));
  }
  return static_cast<std::uint64_t>(frame);
}

void throw_frame_error(const ParticleReadOptions& options, std::uint64_t frames) {
  const std::string there_are = frames == 1
                                    ? "there is one frame in the file, frame 0"
                                    : fmt::format("there are {} frames in the file, from 0 to {}", frames, frames - 1);
  if (!options.frame)
    throw InvalidParticleFile(there_are, {{Remedy::choose, Setting::volume},
                                          {Remedy::set, Setting::volume, "all to convert every frame of one file"}});
  throw InvalidParticleFile(fmt::format("there is no frame {}", *options.frame), there_are);
}

Result<std::optional<ParticleFormatDescription>> detect_particles(const std::string& input,
                                                                  const ParticleReadOptions& options,
                                                                  const Context& context) {
  return with_input(
      input, options, context,
      [&](const files::InputFile& file) -> std::optional<ParticleFormatDescription> {
        const ParticleFormat* format = format_of(file, options, true);
        if (format == nullptr) return std::nullopt;
        return format->about();
      },
      true);
}

Result<ParticleInfo> list_particles(const std::string& input, const ParticleReadOptions& options,
                                    const Context& context) {
  return with_input(input, options, context, [&](const files::InputFile& file) {
    const ParticleFormat& format = checked_format(file, options);
    ParticleInfo info = format.info(file, options);
    info.format = format.about().id;
    return info;
  });
}

Result<files::FilePart> find_frame_part(const std::string& input, const ParticleReadOptions& options,
                                        const Context& context) {
  return with_input(input, options, context, [&](const files::InputFile& file) {
    return files::FilePart{input, checked_format(file, options).frame_ranges(file, options)};
  });
}

Result<FrameTime> find_frame_time(const std::string& input, const ParticleReadOptions& options,
                                  const Context& context) {
  return with_input(input, options, context, [&](const files::InputFile& file) {
    return checked_format(file, options).frame_time(file, options);
  });
}

Result<ParticleFile> read_particles(const std::string& input, const ParticleReadOptions& options,
                                    const Context& context) {
  return with_input(input, options, context, [&](const files::InputFile& file) {
    const ParticleFormat& format = checked_format(file, options);
    ParticleFile read = format.read(file, options);
    complete(read, format, file);
    return read;
  });
}

Result<DescribedParticles> describe_particles(const std::string& input, const ParticleReadOptions& options,
                                              const Context& context) {
  return with_input(input, options, context, [&](const files::InputFile& file) {
    const ParticleFormat& format = checked_format(file, options);
    DescribedParticles described = format.describe(file, options);
    described.info.format = format.about().id;
    complete(described.file, format, file);
    return described;
  });
}

}  // namespace isoextract::particle_io
