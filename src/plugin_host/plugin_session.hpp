// Reads a file with a plug-in, in a child process or, for trusted files, in this one. Callers see the same interface,
// and must validate the results in both cases.
//
// If a plug-in crashes, hangs or returns wrong sizes in a child process, the caller gets an error for that file. In
// this process a crash ends the program. Code that reads files with a new kind of plug-in must use this interface, too.
// tests/plugins/hostile_volume.cpp is a plug-in that misbehaves on purpose.
//
// To debug a plug-in, let it run in the program's own process: with --in-process, or in a program that does not call
// run_as_plugin_reader(), such as a fuzz target.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <particle_plugin.h>
#include <volume_plugin.h>
#include "base/context.hpp"
#include "base/error.hpp"
#include "files/file_bytes.hpp"
#include "plugin_host/plugin_library.hpp"

namespace isoextract::plugin_host {

// Implements read_in_process() of plugin_reader.hpp.
void read_files_in_process();

// A file or folder to read, and what to list of it (isoextract_volume_request).
struct VolumeInput {
  std::string name;  // for messages
  std::string path;
  std::optional<std::vector<std::byte>> start;  // the first files::kStartBytes of a file; nothing for a folder
  std::uint64_t bytes = 0;                      // size of all files that the plug-in may read, for its limits
  std::vector<std::string> files;
  std::uint64_t volume = 0;
  std::uint64_t level = 0;
  std::array<double, 3> spacing{};
  bool resamples = false;
  Context context;
};

// Which samples of a list to read (isoextract_volume_selection).
struct VolumeSelection {
  std::size_t grid = 0;
  std::uint64_t volume = 0;
  std::int64_t component = 0;  // or ISOEXTRACT_COMPONENT_LENGTH
  std::array<std::uint64_t, 3> first{};
  std::array<std::uint64_t, 3> count{};
  std::uint64_t box_bytes = 0;  // size of these samples, for which the caller has reserved memory; 0 for a sparse grid
};

// Samples as given by a plug-in.
struct SessionSamples {
  const isoextract_volume_samples* samples = nullptr;
  const void* box = nullptr;          // the samples of a dense grid, aligned to 64 bytes
  std::shared_ptr<const void> owner;  // keeps the samples and their reservation alive
};

// A volume file opened with a plug-in. Its texts and lists live as long as this object.
class VolumeSession {
 public:
  VolumeSession() = default;
  VolumeSession(const VolumeSession&) = delete;
  VolumeSession& operator=(const VolumeSession&) = delete;
  virtual ~VolumeSession() = default;

  [[nodiscard]] virtual std::string format() const = 0;
  [[nodiscard]] virtual const isoextract_volume_list& list() const = 0;
  // Reads samples; may be called again, for other samples.
  [[nodiscard]] virtual Result<SessionSamples> open(const VolumeSelection& selection) = 0;
  // Closes the session after the last open(); the samples stay valid. Fails if the plug-in did not end normally.
  [[nodiscard]] virtual Result<void> finish() { return {}; }
  // Returns the captured output of the plug-in and its library as one line; may be empty.
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

// Lists the grids of a file. Fails if the plug-in is missing (ErrorCode::unavailable), if it rejects or cannot read the
// file, crashes on it, or exceeds its limits of time or memory.
[[nodiscard]] Result<std::unique_ptr<VolumeSession>> open_volume_session(const PluginLibrary& library,
                                                                         const std::string& id,
                                                                         const VolumeInput& input);

class ParticleSession {
 public:
  ParticleSession() = default;
  ParticleSession(const ParticleSession&) = delete;
  ParticleSession& operator=(const ParticleSession&) = delete;
  virtual ~ParticleSession() = default;

  [[nodiscard]] virtual const isoextract_particle_file& file() const = 0;
  [[nodiscard]] virtual Result<void> positions(std::span<double> values) = 0;
  [[nodiscard]] virtual Result<void> quantity(std::size_t number, std::span<float> values) = 0;
  // Closes the session; call no other function afterwards. Fails if the plug-in did not end normally.
  [[nodiscard]] virtual Result<void> finish() { return {}; }
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

struct ParticleSelection {
  std::uint64_t frame = 0;
  const std::string* grid = nullptr;  // name of the point grid; null if none was given
};

// Opens a frame of a file. Fails as open_volume_session() does.
[[nodiscard]] Result<std::unique_ptr<ParticleSession>> open_particle_session(const PluginLibrary& library,
                                                                             const std::string& id,
                                                                             const files::InputFile& file,
                                                                             const ParticleSelection& wanted);

// Opens a file in a child process. open_volume_session() and open_particle_session() call these functions unless files
// are read in this process.
[[nodiscard]] Result<std::unique_ptr<VolumeSession>> open_volume_in_worker(const PluginLibrary& library,
                                                                           const std::string& id,
                                                                           const VolumeInput& input);
[[nodiscard]] Result<std::unique_ptr<ParticleSession>> open_particles_in_worker(const PluginLibrary& library,
                                                                                const std::string& id,
                                                                                const files::InputFile& file,
                                                                                const ParticleSelection& wanted);

// plugin_error(), wrong_format_error() and plugin_needs() make the texts of messages, so that sessions in this process
// and in a worker have the same.

// Returns the error with the plug-in's text, for an isoextract_read_failure.
[[nodiscard]] Error plugin_error(const std::string& input, const std::string& text,
                                 std::int32_t failure = ISOEXTRACT_READ_FAILED);
// Returns the error for a file that is not of the plug-in's format.
[[nodiscard]] Error wrong_format_error(const std::string& input, const std::string& id,
                                       std::span<const std::byte> start);
// Returns the text that names this read in messages about memory: "INPUT: reading with the plug-in for ID".
[[nodiscard]] std::string plugin_needs(const std::string& input, const std::string& id);

}  // namespace isoextract::plugin_host
