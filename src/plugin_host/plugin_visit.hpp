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
void trust_files();

// Samples as given by a plug-in.
struct VisitedSamples {
  const isoextract_volume_samples* samples = nullptr;
  std::shared_ptr<const void> owner;  // keeps the samples and their reservation alive
};

// A volume file opened with a plug-in. Its texts and lists live as long as this object.
class VolumeVisit {
 public:
  VolumeVisit() = default;
  VolumeVisit(const VolumeVisit&) = delete;
  VolumeVisit& operator=(const VolumeVisit&) = delete;
  virtual ~VolumeVisit() = default;

  [[nodiscard]] virtual std::string format() const = 0;
  [[nodiscard]] virtual const isoextract_volume_list& list() const = 0;
  // Reads a grid; call once. `box_bytes` is the size of a full box, for which the caller has reserved memory; 0 for
  // sparse samples.
  [[nodiscard]] virtual Result<VisitedSamples> open(std::size_t grid, std::uint64_t box_bytes) = 0;
  // Returns the captured output of the plug-in and its library as one line; may be empty.
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

// Lists the grids of a file. Fails if the plug-in is missing (ErrorCode::unavailable), if it rejects or cannot read the
// file, crashes on it, or exceeds its limits of time or memory.
[[nodiscard]] Result<std::unique_ptr<VolumeVisit>> visit_volume(const PluginLibrary& library, const std::string& id,
                                                                const files::InputFile& file);

class ParticleVisit {
 public:
  ParticleVisit() = default;
  ParticleVisit(const ParticleVisit&) = delete;
  ParticleVisit& operator=(const ParticleVisit&) = delete;
  virtual ~ParticleVisit() = default;

  [[nodiscard]] virtual const isoextract_particle_file& file() const = 0;
  [[nodiscard]] virtual Result<void> positions(std::span<double> values) = 0;
  [[nodiscard]] virtual Result<void> quantity(std::size_t number, std::span<float> values) = 0;
  // Ends the visit; no calls may follow. Fails if the plug-in did not end normally.
  [[nodiscard]] virtual Result<void> finish() { return {}; }
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

struct WantedParticles {
  std::uint64_t frame = 0;
  const std::string* grid = nullptr;  // may be null
};

// Opens a frame of a file. Fails as visit_volume() does.
[[nodiscard]] Result<std::unique_ptr<ParticleVisit>> visit_particles(const PluginLibrary& library,
                                                                     const std::string& id,
                                                                     const files::InputFile& file,
                                                                     const WantedParticles& wanted);

// Opens the file in a child process; the two functions above call it.
[[nodiscard]] Result<std::unique_ptr<VolumeVisit>> visit_volume_apart(const PluginLibrary& library,
                                                                      const std::string& id,
                                                                      const files::InputFile& file);
[[nodiscard]] Result<std::unique_ptr<ParticleVisit>> visit_particles_apart(const PluginLibrary& library,
                                                                           const std::string& id,
                                                                           const files::InputFile& file,
                                                                           const WantedParticles& wanted);

// Makes the errors and messages that both ways share.
[[nodiscard]] Error plugin_failed(const std::string& input, const std::string& text);
[[nodiscard]] Error not_of_format(const std::string& input, const std::string& id, std::span<const std::byte> start);
[[nodiscard]] std::string plugin_needs(const std::string& input, const std::string& id);
// Returns the first bytes of a file without decompressing them.
[[nodiscard]] Result<std::vector<std::byte>> start_as_stored(const files::InputFile& file);

}  // namespace isoextract::plugin_host
