// Reads particles with workers: sends requests and validates the replies.
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "files/unpacked_files.hpp"
#include "plugin_host/detail/worker_conversation.hpp"
#include "plugin_host/plugin_session.hpp"

namespace isoextract::plugin_host {
namespace {

using sandbox::MessageReader;
using sandbox::MessageWriter;

class WorkerParticleSession final : public ParticleSession {
 public:
  explicit WorkerParticleSession(std::unique_ptr<WorkerConversation> talk) : talk_(std::move(talk)) {}

  Result<void> open(const files::InputFile& file, const ParticleSelection& wanted) {
    talk_->tell(say(MessageKind::open_particles)
                    .text(files::openable_path(file))
                    .number(wanted.grid == nullptr ? 0 : 1)
                    .text(wanted.grid == nullptr ? std::string_view() : *wanted.grid)
                    .number(wanted.frame));
    auto answer = TRY(talk_->hear());
    if (answer.what != MessageKind::particles_opened || !take_file(answer.message))
      return talk_->refused("no particles");
    return {};
  }

  [[nodiscard]] const isoextract_particle_file& file() const override { return file_; }
  [[nodiscard]] std::string printed() const override { return talk_->printed(); }

  [[nodiscard]] Result<void> positions(std::span<double> values) override {
    return fill(say(MessageKind::positions), std::as_writable_bytes(values));
  }
  [[nodiscard]] Result<void> quantity(std::size_t number, std::span<float> values) override {
    return fill(say(MessageKind::quantity).number(number), std::as_writable_bytes(values));
  }
  [[nodiscard]] Result<void> finish() override { return talk_->finish(); }

 private:
  bool take_file(MessageReader& message) {
    file_.particles = message.number();
    file_.frames = message.number();
    file_.held_bytes = message.number();
    const bool has_texts = take_text(message, frame_name_) && take_text(message, length_unit_);
    const bool has_list = message.number() != 0;
    const std::uint64_t count = message.number();
    constexpr std::uint64_t kQuantityBytes = 5 * sizeof(std::uint64_t);  // least size of a quantity in the message
    if (!has_texts || (has_list && count > message.left() / kQuantityBytes)) return false;
    quantities_.resize(has_list ? static_cast<std::size_t>(count) : 0);
    texts_.resize(2 * quantities_.size());
    for (std::size_t i = 0; i < quantities_.size(); ++i) {
      if (!take_text(message, texts_[2 * i]) || !take_text(message, texts_[2 * i + 1])) return false;
      quantities_[i].name = texts_[2 * i].c_str();
      quantities_[i].type_name = texts_[2 * i + 1].c_str();
      quantities_[i].components = message.number();
      quantities_[i].is_numeric = signed_of(message.number());
      quantities_[i].kind = signed_of(message.number());
    }
    file_.frame_name = frame_name_.c_str();
    file_.length_unit = length_unit_.c_str();
    file_.quantities = has_list ? quantities_.data() : nullptr;
    file_.quantity_count = static_cast<std::size_t>(count);
    return message.is_whole();
  }

  static bool take_text(MessageReader& message, std::string& to) {
    to = message.text();
    return to.size() <= kMaxText;
  }

  Result<void> fill(const MessageWriter& what, std::span<std::byte> values) {
    // The worker needs as many bytes for its copy.
    const auto reserved = TRY(talk_->context().reserve(values.size(), plugin_needs(talk_->name(), talk_->id())));
    talk_->tell(what);
    auto answer = TRY(talk_->hear());
    if (answer.what != MessageKind::filled || answer.message.number() != values.size()) {
      return talk_->refused(fmt::format("a wrong number of bytes, expected {}", values.size()));
    }
    return talk_->take(values);
  }

  std::unique_ptr<WorkerConversation> talk_;
  isoextract_particle_file file_{};
  std::string frame_name_;
  std::string length_unit_;
  std::vector<isoextract_particle_quantity> quantities_;
  std::vector<std::string> texts_;
};

}  // namespace

Result<std::unique_ptr<ParticleSession>> open_particles_in_worker(const PluginLibrary& library, const std::string& id,
                                                                  const files::InputFile& file,
                                                                  const ParticleSelection& wanted) {
  auto talk = TRY(start_conversation(library, id, file.name(), file.size(), file.context()));
  auto visit = std::make_unique<WorkerParticleSession>(std::move(talk));
  TRY(visit->open(file, wanted));
  return visit;
}

}  // namespace isoextract::plugin_host
