// A file in the hands of a plug-in: in a child process, or in this one where its files are trusted. What comes of it is
// the same for whoever asks, and is not believed in either case.
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

// From now on files are read in this process.
void trust_files();

// Samples as a plug-in has given them.
struct VisitedSamples {
  const isoextract_volume_samples* samples = nullptr;
  std::shared_ptr<const void> owner;  // keeps them alive, and what is reserved for them
};

// Texts and lists live as long as this.
class VolumeVisit {
 public:
  VolumeVisit() = default;
  VolumeVisit(const VolumeVisit&) = delete;
  VolumeVisit& operator=(const VolumeVisit&) = delete;
  virtual ~VolumeVisit() = default;

  [[nodiscard]] virtual std::string format() const = 0;
  [[nodiscard]] virtual const isoextract_volume_list& list() const = 0;
  // Once. `box_bytes` are those of a full box, for which the caller has reserved memory; 0 for sparse samples.
  [[nodiscard]] virtual Result<VisitedSamples> open(std::size_t grid, std::uint64_t box_bytes) = 0;
  // What the plug-in and its library have printed, as one line, so that nobody else hears it; may be empty.
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

// Lists what is in a file. Fails where the plug-in is not there (ErrorCode::unavailable), and where it takes the file
// for none of its format, cannot read it, crashes over it, or wants more time or memory than it may have.
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
  // Nothing more is asked for. Fails where the plug-in has not come to a good end.
  [[nodiscard]] virtual Result<void> finish() { return {}; }
  [[nodiscard]] virtual std::string printed() const { return {}; }
};

struct WantedParticles {
  std::uint64_t frame = 0;
  const std::string* grid = nullptr;  // or null
};

// Opens a frame of a file. Fails as visit_volume does.
[[nodiscard]] Result<std::unique_ptr<ParticleVisit>> visit_particles(const PluginLibrary& library,
                                                                     const std::string& id,
                                                                     const files::InputFile& file,
                                                                     const WantedParticles& wanted);

// The same in a child process; for those two.
[[nodiscard]] Result<std::unique_ptr<VolumeVisit>> visit_volume_apart(const PluginLibrary& library,
                                                                      const std::string& id,
                                                                      const files::InputFile& file);
[[nodiscard]] Result<std::unique_ptr<ParticleVisit>> visit_particles_apart(const PluginLibrary& library,
                                                                           const std::string& id,
                                                                           const files::InputFile& file,
                                                                           const WantedParticles& wanted);

// What all of them say.
[[nodiscard]] Error plugin_failed(const std::string& input, const std::string& text);
[[nodiscard]] Error not_of_format(const std::string& input, const std::string& id, std::span<const std::byte> start);
[[nodiscard]] std::string plugin_needs(const std::string& input, const std::string& id);
// The first bytes of a file as they lie in it.
[[nodiscard]] Result<std::vector<std::byte>> start_as_stored(const files::InputFile& file);

}  // namespace isoextract::plugin_host
