#include "plugin_host/plugin_session.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include <fmt/format.h>

#include "base/buffer.hpp"
#include "base/printable.hpp"
#include "files/unpacked_files.hpp"
#include "plugin_host/detail/volume_request.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "sandbox/program.hpp"

namespace isoextract::plugin_host {
namespace {

using VolumePlugin = isoextract_volume_plugin_v4;
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
  Buffer<std::byte> box;
  isoextract_volume_samples samples{};
  bool is_given = false;
};

class VolumeHere final : public VolumeSession {
 public:
  VolumeHere(const VolumePlugin& plugin, std::string id, const VolumeInput& input)
      : plugin_(plugin), id_(std::move(id)), input_(input), memory_(input.context, plugin_needs(input.name, id_)) {}
  ~VolumeHere() override {
    if (is_listed_) plugin_.free_list(&list_);
  }

  Result<void> fill_list() {
    std::vector<const char*> files;
    for (const std::string& file : input_.files) files.push_back(file.c_str());
    const VolumeRequest request(input_, files);
    if (const int failure = plugin_.list(&request.get(), &memory_.host(), &list_); failure != 0) {
      return tl::unexpected(memory_.refusal_or(error_of(failure)));
    }
    is_listed_ = true;
    return {};
  }

  [[nodiscard]] std::string format() const override {
    return list_.format == nullptr ? plugin_text(plugin_.format) : list_.format;
  }
  [[nodiscard]] const isoextract_volume_list& list() const override { return list_; }

  [[nodiscard]] Result<SessionSamples> open(const VolumeSelection& wanted) override {
    const auto given = std::make_shared<GivenSamples>(plugin_, input_.context, plugin_needs(input_.name, id_));
    given->box = Buffer<std::byte>(static_cast<std::size_t>(wanted.box_bytes));
    const isoextract_volume_selection selection = selection_of(wanted, given->box.data());
    if (const int failure = plugin_.open(&list_, &selection, &given->memory.host(), &given->samples); failure != 0) {
      return tl::unexpected(given->memory.refusal_or(error_of(failure)));
    }
    given->is_given = true;
    return SessionSamples{&given->samples, given->box.data(), given};
  }

 private:
  [[nodiscard]] Error error_of(int failure) const {
    return plugin_error(input_.name, plugin_text(plugin_.error_text()), failure);
  }

  const VolumePlugin& plugin_;
  std::string id_;
  VolumeInput input_;
  PluginMemory memory_;
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
    const auto opened = done(plugin_.open(files::openable_path(file).c_str(), grid, wanted.frame, &file_));
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

Error plugin_error(const std::string& input, const std::string& text, std::int32_t failure) {
  return {ErrorCode::input,
          fmt::format("{}: {}", input, text.empty() ? "the plug-in failed and gave no reason" : printable(text, 400)),
          failure == ISOEXTRACT_UNEVEN_SAMPLES ? Hint(Remedy::give, Setting::even_spacing) : Hint()};
}

Error wrong_format_error(const std::string& input, const std::string& id, std::span<const std::byte> start) {
  return {ErrorCode::input,
          fmt::format("{}: not a file of the format {}; it starts with '{}'", input, id, printable(start, 16)),
          {}};
}

std::string plugin_needs(const std::string& input, const std::string& id) {
  return fmt::format("{}: reading with the plug-in for {}", input, id);
}

VolumeRequest::VolumeRequest(const VolumeInput& input, std::span<const char* const> files) {
  request_.path = input.path.c_str();
  request_.files = files.data();
  request_.file_count = files.size();
  request_.volume = input.volume;
  request_.level = input.level;
  std::ranges::copy(input.spacing, request_.spacing);
  request_.resamples = input.resamples ? 1 : 0;
}

isoextract_volume_selection selection_of(const VolumeSelection& wanted, void* box) {
  isoextract_volume_selection selection{};
  selection.grid = wanted.grid;
  selection.volume = wanted.volume;
  selection.component = wanted.component;
  std::ranges::copy(wanted.first, selection.first);
  std::ranges::copy(wanted.count, selection.count);
  selection.box = box;
  return selection;
}

Result<std::unique_ptr<VolumeSession>> open_volume_session(const PluginLibrary& library, const std::string& id,
                                                           const VolumeInput& input) {
  if (reads_apart()) return open_volume_in_worker(library, id, input);
  const auto opened = TRY(library.opened(input.name));
  const auto& plugin = *static_cast<const VolumePlugin*>(opened);
  if (input.start) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(input.start->data());
    if (plugin.probe(bytes, input.start->size(), input.path.c_str()) == 0) {
      return tl::unexpected(wrong_format_error(input.name, id, *input.start));
    }
  }
  auto visit = std::make_unique<VolumeHere>(plugin, id, input);
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
