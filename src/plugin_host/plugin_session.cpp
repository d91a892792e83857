#include "plugin_host/plugin_session.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "sandbox/program.hpp"

namespace isoextract::plugin_host {
namespace {

using VolumePlugin = isoextract_volume_plugin_v3;
using ParticlePlugin = isoextract_particle_plugin_v3;

std::atomic<bool> files_are_trusted{false};

bool reads_apart() { return sandbox::can_start_children() && !files_are_trusted; }

// Owns a plug-in's samples and their reservation.
struct GivenSamples {
  GivenSamples(const VolumePlugin& the_plugin, const Context& context, std::string what)
      : plugin(the_plugin), memory(context, std::move(what)) {}
  GivenSamples(const GivenSamples&) = delete;
  GivenSamples& operator=(const GivenSamples&) = delete;
  ~GivenSamples() {
    if (is_given) plugin.free_samples(&samples);
  }

  const VolumePlugin& plugin;
  PluginMemory memory;
  isoextract_volume_samples samples{};
  bool is_given = false;
};

class VolumeHere final : public VolumeSession {
 public:
  VolumeHere(const VolumePlugin& plugin, std::string id, const files::InputFile& file)
      : plugin_(plugin),
        id_(std::move(id)),
        name_(file.name()),
        path_(file.path().string()),
        context_(file.context()) {}
  ~VolumeHere() override {
    if (is_listed_) plugin_.free_list(&list_);
  }

  Result<void> fill_list() {
    if (plugin_.list(path_.c_str(), &list_) != 0) {
      return tl::unexpected(plugin_error(name_, plugin_text(plugin_.error_text())));
    }
    is_listed_ = true;
    return {};
  }

  [[nodiscard]] std::string format() const override { return plugin_text(plugin_.format); }
  [[nodiscard]] const isoextract_volume_list& list() const override { return list_; }

  [[nodiscard]] Result<SessionSamples> open(std::size_t grid, std::uint64_t /*box_bytes*/) override {
    const auto given = std::make_shared<GivenSamples>(plugin_, context_, plugin_needs(name_, id_));
    if (plugin_.open(path_.c_str(), grid, &given->memory.host(), &given->samples) != 0) {
      return tl::unexpected(given->memory.refusal_or(plugin_error(name_, plugin_text(plugin_.error_text()))));
    }
    given->is_given = true;
    return SessionSamples{&given->samples, given};
  }

 private:
  const VolumePlugin& plugin_;
  std::string id_;
  std::string name_;
  std::string path_;
  Context context_;
  isoextract_volume_list list_{};
  bool is_listed_ = false;
};

class ParticlesHere final : public ParticleSession {
 public:
  ParticlesHere(const ParticlePlugin& plugin, std::string name) : plugin_(plugin), name_(std::move(name)) {}
  ~ParticlesHere() override {
    if (is_open_) plugin_.close(&file_);
  }

  Result<void> open(const files::InputFile& file, const ParticleSelection& wanted) {
    const char* grid = wanted.grid == nullptr ? nullptr : wanted.grid->c_str();
    const auto opened = done(plugin_.open(file.path().c_str(), grid, wanted.frame, &file_));
    is_open_ = opened.has_value();
    return opened;
  }

  [[nodiscard]] const isoextract_particle_file& file() const override { return file_; }
  [[nodiscard]] Result<void> positions(std::span<double> values) override {
    return done(plugin_.positions(&file_, values.data()));
  }
  [[nodiscard]] Result<void> quantity(std::size_t number, std::span<float> values) override {
    return done(plugin_.quantity(&file_, number, values.data()));
  }

 private:
  [[nodiscard]] Result<void> done(int status) const {
    if (status != 0) return tl::unexpected(plugin_error(name_, plugin_text(plugin_.error_text())));
    return {};
  }

  const ParticlePlugin& plugin_;
  std::string name_;
  isoextract_particle_file file_{};
  bool is_open_ = false;
};

}  // namespace

void read_files_in_process() { files_are_trusted = true; }

Error plugin_error(const std::string& input, const std::string& text) {
  return {ErrorCode::input,
          fmt::format("{}: {}", input, text.empty() ? "the plug-in failed and gave no reason" : printable(text, 400)),
          {}};
}

Error wrong_format_error(const std::string& input, const std::string& id, std::span<const std::byte> start) {
  return {ErrorCode::input,
          fmt::format("{}: not a file of the format {}; it starts with '{}'", input, id, printable(start, 16)),
          {}};
}

std::string plugin_needs(const std::string& input, const std::string& id) {
  return fmt::format("{}: reading with the plug-in for {}", input, id);
}

Result<std::vector<std::byte>> raw_first_bytes(const files::InputFile& file) {
  std::vector<std::byte> start(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), files::kStartBytes)));
  TRY(file.read_at(0, start));
  return start;
}

Result<std::unique_ptr<VolumeSession>> open_volume_session(const PluginLibrary& library, const std::string& id,
                                                           const files::InputFile& file) {
  if (reads_apart()) return open_volume_in_worker(library, id, file);
  const auto opened = TRY(library.opened(file.name()));
  const auto& plugin = *static_cast<const VolumePlugin*>(opened);
  const auto start = TRY(raw_first_bytes(file));
  const auto* bytes = reinterpret_cast<const unsigned char*>(start.data());
  if (plugin.probe(bytes, start.size(), file.path().c_str()) == 0) {
    return tl::unexpected(wrong_format_error(file.name(), id, start));
  }
  auto visit = std::make_unique<VolumeHere>(plugin, id, file);
  TRY(visit->fill_list());
  return visit;
}

Result<std::unique_ptr<ParticleSession>> open_particle_session(const PluginLibrary& library, const std::string& id,
                                                               const files::InputFile& file,
                                                               const ParticleSelection& wanted) {
  if (reads_apart()) return open_particles_in_worker(library, id, file, wanted);
  const auto opened = TRY(library.opened(file.name()));
  auto visit = std::make_unique<ParticlesHere>(*static_cast<const ParticlePlugin*>(opened), file.name());
  TRY(visit->open(file, wanted));
  return visit;
}

}  // namespace isoextract::plugin_host
