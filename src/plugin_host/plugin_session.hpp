// Reads a file with a plug-in, in a child process or, for trusted files, in this one. Callers see the same interface,
// and must validate the results in both cases.
//
// A plug-in that crashes, hangs or gives false sizes makes an error of the file. A new kind of plug-in that reads files
// must use this header, too; tests/plugins/hostile_volume.cpp plays a broken library. A debugger wants --in-process, or
// a program that does not call run_as_plugin_reader, such as a fuzz target: both read in their own process.
#pragma once

#include <cstdint>
#include <memory>
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

// Makes plug-ins read files in this process from now on.
void read_files_in_process();

// Samples as given by a plug-in.
struct SessionSamples {
  const isoextract_volume_samples* samples = nullptr;
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
  // Reads a grid; call once. `box_bytes` is the size of a full box, for which the caller has reserved memory; 0 for
  // sparse samples.
  [[nodiscard]] virtual Result<SessionSamples> open(std::size_t grid, std::uint64_t box_bytes) = 0;
  // Returns the captured output of the plug-in and its library as one line; may be empty.
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

// Lists the grids of a file. Fails if the plug-in is missing (ErrorCode::unavailable), if it rejects or cannot read the
// file, crashes on it, or exceeds its limits of time or memory.
[[nodiscard]] Result<std::unique_ptr<VolumeSession>> open_volume_session(const PluginLibrary& library,
                                                                         const std::string& id,
                                                                         const files::InputFile& file);

class ParticleSession {
 public:
  ParticleSession() = default;
  ParticleSession(const ParticleSession&) = delete;
  ParticleSession& operator=(const ParticleSession&) = delete;
  virtual ~ParticleSession() = default;

  [[nodiscard]] virtual const isoextract_particle_file& file() const = 0;
  [[nodiscard]] virtual Result<void> positions(std::span<double> values) = 0;
  [[nodiscard]] virtual Result<void> quantity(std::size_t number, std::span<float> values) = 0;
  // Ends the visit; no calls may follow. Fails if the plug-in did not end normally.
  [[nodiscard]] virtual Result<void> finish() { return {}; }
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

struct ParticleSelection {
  std::uint64_t frame = 0;
  const std::string* grid = nullptr;  // may be null
};

// Opens a frame of a file. Fails as open_volume_session() does.
[[nodiscard]] Result<std::unique_ptr<ParticleSession>> open_particle_session(const PluginLibrary& library,
                                                                             const std::string& id,
                                                                             const files::InputFile& file,
                                                                             const ParticleSelection& wanted);

// Opens the file in a child process; the two functions above call it.
[[nodiscard]] Result<std::unique_ptr<VolumeSession>> open_volume_in_worker(const PluginLibrary& library,
                                                                           const std::string& id,
                                                                           const files::InputFile& file);
[[nodiscard]] Result<std::unique_ptr<ParticleSession>> open_particles_in_worker(const PluginLibrary& library,
                                                                                const std::string& id,
                                                                                const files::InputFile& file,
                                                                                const ParticleSelection& wanted);

// Makes the errors and messages that both ways share.
[[nodiscard]] Error plugin_error(const std::string& input, const std::string& text);
[[nodiscard]] Error wrong_format_error(const std::string& input, const std::string& id,
                                       std::span<const std::byte> start);
[[nodiscard]] std::string plugin_needs(const std::string& input, const std::string& id);
// Returns the first bytes of a file without decompressing them.
[[nodiscard]] Result<std::vector<std::byte>> raw_first_bytes(const files::InputFile& file);

}  // namespace isoextract::plugin_host
