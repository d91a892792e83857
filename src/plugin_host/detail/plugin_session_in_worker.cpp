// Reads files with workers: sends requests and validates the replies.
#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "base/byte_size.hpp"
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "field/samples.hpp"
#include "plugin_host/detail/plugin_messages.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "plugin_host/plugin_session.hpp"
#include "sandbox/shared_memory.hpp"
#include "sandbox/worker.hpp"

namespace isoextract::plugin_host {
namespace {

using sandbox::Mapping;
using sandbox::MessageReader;
using sandbox::MessageWriter;
using sandbox::SharedMemory;
using sandbox::WorkerEnd;

constexpr const char* kSecondsVariable = "ISOEXTRACT_PLUGIN_SECONDS";
constexpr std::uint64_t kUsualSeconds = 60;
constexpr std::size_t kMaxText = 4096;          // longest name in bytes
constexpr std::size_t kMaxSharedMemories = 64;  // most shared memories of a worker; each uses a descriptor

// Returns the time and memory limits of a worker. Adds the size of the file to the memory, as libraries map it.
Result<sandbox::Limits> limits_for(const files::InputFile& file) {
  std::uint64_t seconds = kUsualSeconds;
  if (const char* given = std::getenv(kSecondsVariable)) {
    const std::string_view text(given);
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (status != std::errc{} || end != text.data() + text.size() || seconds == 0) {
      return fail(ErrorCode::usage, fmt::format("the environment variable {}: expected 1 or more seconds, found '{}'",
                                                kSecondsVariable, printable(text, 40)));
    }
  }
  sandbox::Limits limits;
  limits.seconds = checked_sum(seconds, file.size() >> 20U).value_or(std::numeric_limits<std::uint64_t>::max());
  const std::uint64_t left = file.context().memory().left();
  limits.memory = checked_sum(left, file.size()).value_or(left);
  limits.threads = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return limits;
}

Result<SharedMemory> share_memory(const std::string& name, std::uint64_t bytes) {
  if (auto memory = SharedMemory::create(bytes)) return std::move(*memory);
  return fail(
      ErrorCode::unavailable,
      fmt::format("{}: the system refuses {} of shared memory (memfd_create) for the process that reads the file", name,
                  format_byte_size(bytes)),
      {Remedy::use, Setting::in_process});
}

// A conversation with the worker that reads one file; turns every way it can end into an error.
class WorkerConversation {
 public:
  WorkerConversation(sandbox::WorkerPool::Started started, std::string id, const files::InputFile& file,
                     const sandbox::Limits& limits)
      : worker_(std::move(started.worker)),
        greeting_(std::move(started.greeting)),
        id_(std::move(id)),
        name_(file.name()),
        context_(file.context()),
        limits_(limits) {}

  struct Heard {
    MessageKind what{};
    MessageReader message;
  };

  void tell(const MessageWriter& message, int descriptor = -1) { worker_->send(message, descriptor); }

  // Returns the worker's next message. Fails if it reports a failure or has ended.
  Result<Heard> hear() {
    auto message = worker_->receive();
    if (!message) return tl::unexpected(error_of(worker_->ending(), "ended"));
    Heard heard{static_cast<MessageKind>(message->number()), std::move(*message)};
    if (heard.what != MessageKind::failed) return heard;
    Error failed = plugin_error(name_, heard.message.text());
    if (worker_->finish().memory_was_refused) {
      failed.message += fmt::format("; the memory limit leaves {}", format_byte_size(limits_.memory));
      failed.code = ErrorCode::out_of_memory;
      failed.hint = {Remedy::raise, Setting::memory_limit};
    }
    return tl::unexpected(std::move(failed));
  }

  // Receives bytes that follow a message.
  Result<void> take(std::span<std::byte> to) {
    if (worker_->receive_bytes(to)) return {};
    return tl::unexpected(error_of(worker_->ending(), "ended"));
  }

  // Ends the worker, after which the shared memory no longer changes.
  Result<void> finish() {
    const WorkerEnd& ending = worker_->finish();
    if (ending.reason == WorkerEnd::Reason::done) return {};
    return tl::unexpected(error_of(ending, "ended"));
  }

  // Returns the error for a reply that is invalid.
  [[nodiscard]] tl::unexpected<Error> refused(const std::string& what) const {
    return fail(ErrorCode::input, fmt::format("{}: the plug-in for {} returns {}", name_, id_, what));
  }

  [[nodiscard]] const std::string& greeting() const { return greeting_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Context& context() const { return context_; }
  [[nodiscard]] std::string printed() const {
    std::string text = worker_->output();
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    std::ranges::replace(text, '\n', ' ');
    return printable(text, 300);
  }

 private:
  [[nodiscard]] Error error_of(const WorkerEnd& ending, const char* otherwise) const {
    const std::string who = fmt::format("{}: the process that read the file with the plug-in for {}", name_, id_);
    constexpr const char* kDamaged = "the file is damaged, or the plug-in's library does not support it";
    switch (ending.reason) {
      case WorkerEnd::Reason::cancelled: return {ErrorCode::cancelled, "cancelled", {}};
      case WorkerEnd::Reason::too_long:
        return {
            ErrorCode::input, fmt::format("{} exceeded its time limit of {} s: {}", who, limits_.seconds, kDamaged),
            fmt::format("if the file is intact, raise the limit with the environment variable {}", kSecondsVariable)};
      case WorkerEnd::Reason::lost:
        return {ErrorCode::unavailable,
                fmt::format("{}: the process for reading the file with the plug-in for {} did not start, or its "
                            "connection broke",
                            name_, id_),
                {Remedy::use, Setting::in_process}};
      case WorkerEnd::Reason::signal:
        if (ending.memory_was_refused) {
          return {ErrorCode::out_of_memory,
                  fmt::format("{} needs more memory than the {} that the memory limit leaves", who,
                              format_byte_size(limits_.memory)),
                  {Remedy::raise, Setting::memory_limit}};
        }
        return {ErrorCode::input, fmt::format("{} crashed (signal {}): {}", who, ending.signal, kDamaged),
                "write the file again, or in another format"};
      case WorkerEnd::Reason::done: break;
    }
    return {ErrorCode::input, fmt::format("{} {} without an answer: {}", who, otherwise, kDamaged), {}};
  }

  std::unique_ptr<sandbox::Worker> worker_;
  std::string greeting_;
  std::string id_;
  std::string name_;
  Context context_;
  sandbox::Limits limits_;
};

Result<std::unique_ptr<WorkerConversation>> start_talk(const PluginLibrary& library, const std::string& id,
                                                       const files::InputFile& file) {
  const auto limits = TRY(limits_for(file));
  auto started = TRY(library.start_worker(file.name(), limits, file.context()));
  return std::make_unique<WorkerConversation>(std::move(started), id, file, limits);
}

std::int32_t signed_of(std::uint64_t bits) { return static_cast<std::int32_t>(bits); }

// Volumes.

// Samples in shared memory.
struct SharedSamples {
  SharedSamples(const Context& context, std::string what) : memory(context, std::move(what)) {}

  PluginMemory memory;
  Reservation box_memory;
  std::vector<SharedMemory> shared;  // until they are mapped
  std::vector<Mapping> mapped;
  std::vector<isoextract_sparse_block> blocks;
  std::vector<isoextract_sparse_tile> tiles;
  isoextract_sparse_samples sparse{};
  std::string note;
  isoextract_volume_samples samples{};

  // Returns a pointer to the `bytes` at `place`; null if they are not all within the memory.
  [[nodiscard]] const std::byte* find(const SharedPlace& place, std::uint64_t bytes) const {
    if (place.memory >= mapped.size()) return nullptr;
    const auto all = mapped[place.memory].bytes();
    if (place.offset > all.size() || bytes > all.size() - place.offset) return nullptr;
    return all.data() + place.offset;
  }
};

// Copies a list of `count` entries from shared memory; returns nothing if it is not within it.
template <class T>
std::optional<std::vector<T>> list_of(const SharedSamples& from, const SharedPlace& place, std::uint64_t count) {
  if (count == 0) return std::vector<T>();
  const auto bytes = checked_product(count, std::uint64_t{sizeof(T)});
  const std::byte* begin = bytes ? from.find(place, *bytes) : nullptr;
  if (begin == nullptr) return std::nullopt;
  std::vector<T> entries(static_cast<std::size_t>(count));
  std::memcpy(entries.data(), begin, static_cast<std::size_t>(*bytes));
  return entries;
}

SharedPlace place_in(MessageReader& message) {
  SharedPlace place;
  place.memory = message.number();
  place.offset = message.number();
  return place;
}

// Returns false if blocks or tiles are not within the shared memory.
bool take_sparse(MessageReader& message, SharedSamples& to) {
  isoextract_sparse_samples& sparse = to.sparse;
  sparse.sample_type = signed_of(message.number());
  sparse.background = message.real();
  sparse.active_voxels = message.number();
  for (int axis = 0; axis < 3; ++axis) {
    sparse.active_min[axis] = signed_of(message.number());
    sparse.active_max[axis] = signed_of(message.number());
  }
  const std::uint64_t block_count = message.number();
  const auto blocks = list_of<SharedBlock>(to, place_in(message), block_count);
  const std::uint64_t tile_count = message.number();
  auto tiles = list_of<isoextract_sparse_tile>(to, place_in(message), tile_count);
  const auto type = sample_type_of(sparse.sample_type);
  if (!message.is_whole() || !blocks || !tiles || !type) return false;
  constexpr std::uint64_t kSide = field::SparseBlock::kSize;
  const std::uint64_t block_bytes = kSide * kSide * kSide * field::sample_size(*type);
  to.blocks.reserve(blocks->size());
  for (const SharedBlock& block : *blocks) {
    const std::byte* values = to.find({block.memory, block.offset}, block_bytes);
    if (values == nullptr) return false;
    to.blocks.push_back({{block.origin[0], block.origin[1], block.origin[2]}, values});
  }
  to.tiles = std::move(*tiles);
  sparse.blocks = to.blocks.data();
  sparse.block_count = to.blocks.size();
  sparse.tiles = to.tiles.data();
  sparse.tile_count = to.tiles.size();
  to.samples.sparse = &sparse;
  return true;
}

class WorkerVolumeSession final : public VolumeSession {
 public:
  explicit WorkerVolumeSession(std::unique_ptr<WorkerConversation> talk) : talk_(std::move(talk)) {}

  Result<void> fill_list(const files::InputFile& file) {
    const auto start = TRY(raw_first_bytes(file));
    const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
    talk_->tell(say(MessageKind::list_volume).text(file.path().string()).text(text));
    auto answer = TRY(talk_->hear());
    if (answer.what == MessageKind::wrong_format)
      return tl::unexpected(wrong_format_error(talk_->name(), talk_->id(), start));
    if (answer.what != MessageKind::listed || !take_list(answer.message)) return talk_->refused("no list of grids");
    return {};
  }

  [[nodiscard]] std::string format() const override { return talk_->greeting(); }
  [[nodiscard]] const isoextract_volume_list& list() const override { return list_; }
  [[nodiscard]] std::string printed() const override { return talk_->printed(); }

  [[nodiscard]] Result<SessionSamples> open(std::size_t grid, std::uint64_t box_bytes) override {
    const auto given = std::make_shared<SharedSamples>(talk_->context(), plugin_needs(talk_->name(), talk_->id()));
    const MessageWriter job = std::move(say(MessageKind::open_grid).number(grid).number(box_bytes));
    if (box_bytes == 0) {
      talk_->tell(job);
    } else {
      auto box = TRY(share_memory(talk_->name(), box_bytes));
      talk_->tell(job, box.descriptor());
      given->shared.push_back(std::move(box));
    }
    auto answer = TRY(answer_after_requests(*given));
    TRY(talk_->finish());
    for (const SharedMemory& memory : given->shared) {
      given->mapped.emplace_back(memory.descriptor(), memory.size(), Mapping::Access::read);
      if (given->mapped.back().bytes().size() != memory.size()) {
        return fail(ErrorCode::input, talk_->name() + ": not enough memory for its samples");
      }
    }
    given->shared.clear();
    MessageReader& message = answer.message;
    given->note = message.text();
    given->samples.note = given->note.c_str();
    const bool has_samples = message.number() != 0;
    if (box_bytes > 0 && answer.what == MessageKind::box_opened) {
      given->samples.data = has_samples ? given->mapped.front().bytes().data() : nullptr;
      given->samples.bytes = message.number();
      if (!message.is_whole()) return talk_->refused("an incomplete answer");
    } else if (box_bytes == 0 && answer.what == MessageKind::grid_opened) {
      if (has_samples && !take_sparse(message, *given))
        return talk_->refused("samples outside the memory that it shares");
    } else {
      return talk_->refused("no samples");
    }
    return SessionSamples{&given->samples, given};
  }

 private:
  bool take_list(MessageReader& message) {
    const std::uint64_t count = message.number();
    constexpr std::uint64_t kGridBytes = 29 * sizeof(std::uint64_t);  // least size of a grid in the message
    if (count > message.left() / kGridBytes) return false;
    grids_.resize(static_cast<std::size_t>(count));
    texts_.reserve(3 * grids_.size());
    const auto text = [&] { return texts_.emplace_back(message.text().substr(0, kMaxText)).c_str(); };
    for (isoextract_volume_grid& grid : grids_) {
      grid.name = text();
      grid.type_name = text();
      grid.world_space = text();
      grid.sample_type = signed_of(message.number());
      grid.kind = signed_of(message.number());
      grid.is_sparse = signed_of(message.number());
      for (std::uint64_t& dim : grid.dims) dim = message.number();
      for (double& entry : grid.index_to_world) entry = message.real();
      grid.has_counts = signed_of(message.number());
      grid.active_voxels = message.number();
      for (int axis = 0; axis < 3; ++axis) {
        grid.active_min[axis] = signed_of(message.number());
        grid.active_max[axis] = signed_of(message.number());
      }
    }
    list_ = {grids_.data(), grids_.size(), nullptr};
    return message.is_whole();
  }

  // Handles the worker's requests for memory until its final reply comes.
  Result<WorkerConversation::Heard> answer_after_requests(SharedSamples& given) {
    const isoextract_plugin_host& host = given.memory.host();
    for (;;) {
      auto heard = talk_->hear();
      if (!heard) return tl::unexpected(given.memory.refusal_or(std::move(heard.error())));
      const std::uint64_t bytes = heard->what == MessageKind::reserve || heard->what == MessageKind::release ||
                                          heard->what == MessageKind::allocate
                                      ? heard->message.number()
                                      : 0;
      if (heard->what == MessageKind::reserve) {
        talk_->tell(say(host.reserve(host.self, bytes) == 0 ? MessageKind::granted : MessageKind::refused));
      } else if (heard->what == MessageKind::release) {
        host.release(host.self, bytes);
      } else if (heard->what == MessageKind::allocate) {
        if (given.shared.size() >= kMaxSharedMemories || !given.memory.hold(bytes)) {
          talk_->tell(say(MessageKind::refused));
          continue;
        }
        auto memory = TRY(share_memory(talk_->name(), bytes));
        talk_->tell(say(MessageKind::granted), memory.descriptor());
        given.shared.push_back(std::move(memory));
      } else {
        return heard;
      }
    }
  }

  std::unique_ptr<WorkerConversation> talk_;
  std::vector<isoextract_volume_grid> grids_;
  std::vector<std::string> texts_;
  isoextract_volume_list list_{};
};

// Particles.

class WorkerParticleSession final : public ParticleSession {
 public:
  explicit WorkerParticleSession(std::unique_ptr<WorkerConversation> talk) : talk_(std::move(talk)) {}

  Result<void> open(const files::InputFile& file, const ParticleSelection& wanted) {
    talk_->tell(say(MessageKind::open_particles)
                    .text(file.path().string())
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

Result<std::unique_ptr<VolumeSession>> open_volume_in_worker(const PluginLibrary& library, const std::string& id,
                                                             const files::InputFile& file) {
  auto talk = TRY(start_talk(library, id, file));
  auto visit = std::make_unique<WorkerVolumeSession>(std::move(talk));
  TRY(visit->fill_list(file));
  return visit;
}

Result<std::unique_ptr<ParticleSession>> open_particles_in_worker(const PluginLibrary& library, const std::string& id,
                                                                  const files::InputFile& file,
                                                                  const ParticleSelection& wanted) {
  auto talk = TRY(start_talk(library, id, file));
  auto visit = std::make_unique<WorkerParticleSession>(std::move(talk));
  TRY(visit->open(file, wanted));
  return visit;
}

}  // namespace isoextract::plugin_host
