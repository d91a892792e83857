// The groups of options that several commands have.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/option_group.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// What --memory-limit is.
inline constexpr const char* kMemoryLimitText =
    "Refuse an input that needs more memory than this, such as 512M or 8G (default: the machine's memory). Samples "
    "that are mapped from their file, not copied, need none.";

// What --iso takes.
inline constexpr const char* kIsoText =
    "The value whose surface is extracted: a number; p99, p0.5 and so on, the percentile of the input's samples; or "
    "auto, "
    "what 'isoextract info INPUT' suggests, for particles the usual value of the method. Percentiles are of all "
    "samples "
    "that are numbers, without the background of sparse grids, whatever --roi and --resolution leave of them.";

// `what` says of the inputs what they are for. Only commands that work through all volumes of a file offer --volume
// all.
enum class VolumesTaken { one, all };
void declare_input(CLI::App& app, InputFlags& flags, const std::string& metavar, const std::string& what,
                   VolumesTaken volumes = VolumesTaken::one);
void declare_particles(CLI::App& app, ParticleFlags& flags);
void declare_surface(const Group& group, SurfaceFlags& flags);
void declare_nan(const Group& group, std::optional<extract::NanPolicy>& policy);
// `text` says what the frames are taken for.
void declare_frame_range(const Group& group, std::optional<batch::FrameRange>& frames, const std::string& text);
void declare_placement(CLI::App& app, PlacementFlags& flags);
void declare_device(const Group& group, DeviceFlags& flags);
void declare_backends(const Group& group, std::optional<std::vector<NamedBackend>>& backends,
                      const std::string& by_default);

// Each is the last of a command's options: with --threads and --verbose, with --verbose, and of a command that says
// nothing but its results and errors.
void declare_run(CLI::App& app, RunFlags& flags);
void declare_verbosity(const Group& group, RunFlags& flags);
void declare_quiet(CLI::App& app, bool& quiet);

}  // namespace isoextract::cli
