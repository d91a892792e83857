// Reads volumes with workers: sends requests and validates the replies.
#include <cstring>
#include <deque>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "field/samples.hpp"
#include "plugin_host/detail/worker_conversation.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "plugin_host/plugin_session.hpp"

namespace isoextract::plugin_host {
namespace {

using sandbox::Mapping;
using sandbox::MessageReader;
using sandbox::MessageWriter;
using sandbox::SharedMemory;

constexpr std::size_t kMaxSharedMemories = 64;  // most shared memories of a worker; each uses a descriptor

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
  explicit WorkerVolumeSession(std::unique_ptr<WorkerConversation> talk)
      : talk_(std::move(talk)), listing_(talk_->context(), plugin_needs(talk_->name(), talk_->id())) {}

  Result<void> fill_list(const VolumeInput& input) {
    MessageWriter request = say(MessageKind::list_volume);
    request.text(input.path).number(input.start ? 1 : 0);
    const auto start = input.start ? std::span<const std::byte>(*input.start) : std::span<const std::byte>();
    request.text({reinterpret_cast<const char*>(start.data()), start.size()}).number(input.files.size());
    for (const std::string& file : input.files) request.text(file);
    request.number(input.volume).number(input.level);
    for (const double spacing : input.spacing) request.real(spacing);
    request.number(input.resamples ? 1 : 0);
    talk_->tell(request);
    auto answer = TRY(answer_after_requests(listing_));
    if (answer.what == MessageKind::wrong_format)
      return tl::unexpected(wrong_format_error(talk_->name(), talk_->id(), start));
    if (answer.what != MessageKind::listed || !take_list(answer.message)) return talk_->refused("no list of grids");
    return {};
  }

  [[nodiscard]] std::string format() const override {
    return list_.format == nullptr ? talk_->greeting() : list_.format;
  }
  [[nodiscard]] const isoextract_volume_list& list() const override { return list_; }
  [[nodiscard]] std::string printed() const override { return talk_->printed(); }

  [[nodiscard]] Result<SessionSamples> open(const VolumeSelection& wanted) override {
    const auto given = std::make_shared<SharedSamples>(talk_->context(), plugin_needs(talk_->name(), talk_->id()));
    MessageWriter job = say(MessageKind::open_grid);
    job.number(wanted.grid).number(wanted.volume).number(static_cast<std::uint64_t>(wanted.component));
    for (const std::uint64_t first : wanted.first) job.number(first);
    for (const std::uint64_t count : wanted.count) job.number(count);
    job.number(wanted.box_bytes);
    if (wanted.box_bytes == 0) {
      talk_->tell(job);
    } else {
      auto box = TRY(share_memory(talk_->name(), wanted.box_bytes));
      talk_->tell(job, box.descriptor());
      given->shared.push_back(std::move(box));
    }
    auto answer = TRY(answer_after_requests(*given));
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
    given->samples.parts_read = message.number();
    given->samples.parts = message.number();
    const void* box = nullptr;
    if (wanted.box_bytes > 0 && answer.what == MessageKind::box_opened) {
      box = given->mapped.front().bytes().data();
      given->samples.filled = message.number();
      if (!message.is_whole()) return talk_->refused("an incomplete answer");
    } else if (wanted.box_bytes == 0 && answer.what == MessageKind::grid_opened) {
      const bool has_samples = message.number() != 0;
      if (has_samples && !take_sparse(message, *given))
        return talk_->refused("samples outside the memory that it shares");
    } else {
      return talk_->refused("no samples");
    }
    return SessionSamples{&given->samples, box, given};
  }
  [[nodiscard]] Result<void> finish() override { return talk_->finish(); }

 private:
  const char* take_text(MessageReader& message) {
    return texts_.emplace_back(message.text().substr(0, kMaxText)).c_str();
  }

  bool take_grid(MessageReader& message, isoextract_volume_grid& grid) {
    grid.name = take_text(message);
    grid.type_name = take_text(message);
    grid.world_space = take_text(message);
    grid.length_unit = take_text(message);
    grid.component_names = take_text(message);
    grid.time_unit = take_text(message);
    grid.sample_type = signed_of(message.number());
    grid.kind = signed_of(message.number());
    grid.is_sparse = signed_of(message.number());
    grid.is_sampled = signed_of(message.number());
    grid.has_placement = signed_of(message.number());
    for (std::uint64_t& dim : grid.dims) dim = message.number();
    for (double& entry : grid.index_to_world) entry = message.real();
    grid.slope = message.real();
    grid.intercept = message.real();
    grid.components = message.number();
    grid.volumes = message.number();
    if (message.number() != 0) {
      if (grid.volumes > message.left() / sizeof(double)) return false;
      std::vector<double>& times = times_.emplace_back(static_cast<std::size_t>(grid.volumes));
      for (double& time : times) time = message.real();
      grid.volume_times = times.data();
    }
    const std::uint64_t label_count = message.number();
    constexpr std::uint64_t kLabelBytes = 6 * sizeof(std::uint64_t);  // least size of a label in the message
    if (label_count > message.left() / kLabelBytes) return false;
    std::vector<isoextract_volume_label>& labels = labels_.emplace_back(static_cast<std::size_t>(label_count));
    for (isoextract_volume_label& label : labels) {
      label.value = static_cast<std::int64_t>(message.number());
      label.name = take_text(message);
      label.has_color = signed_of(message.number());
      for (double& channel : label.color) channel = message.real();
    }
    grid.labels = labels.data();
    grid.label_count = labels.size();
    grid.has_counts = signed_of(message.number());
    grid.active_voxels = message.number();
    for (int axis = 0; axis < 3; ++axis) {
      grid.active_min[axis] = signed_of(message.number());
      grid.active_max[axis] = signed_of(message.number());
    }
    return message.is_whole();
  }

  bool take_list(MessageReader& message) {
    const bool names_format = message.number() != 0;
    const char* format = take_text(message);
    if (names_format) list_.format = format;
    list_.creator = take_text(message);
    list_.note = take_text(message);
    const std::uint64_t count = message.number();
    constexpr std::uint64_t kGridBytes = 39 * sizeof(std::uint64_t);  // least size of a grid in the message
    if (count > message.left() / kGridBytes) return false;
    grids_.resize(static_cast<std::size_t>(count));
    for (isoextract_volume_grid& grid : grids_) {
      if (!take_grid(message, grid)) return false;
    }
    const std::uint64_t file_count = message.number();
    if (file_count > message.left() / sizeof(std::uint64_t)) return false;
    for (std::uint64_t i = 0; i < file_count; ++i) files_.push_back(take_text(message));
    list_.grids = grids_.data();
    list_.count = grids_.size();
    list_.files = files_.data();
    list_.file_count = files_.size();
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
  SharedSamples listing_;  // holds the memory that the plug-in reserves while it lists
  std::vector<isoextract_volume_grid> grids_;
  std::deque<std::string> texts_;  // a deque, as the list has their addresses
  std::deque<std::vector<double>> times_;
  std::deque<std::vector<isoextract_volume_label>> labels_;
  std::vector<const char*> files_;
  isoextract_volume_list list_{};
};

}  // namespace

Result<std::unique_ptr<VolumeSession>> open_volume_in_worker(const PluginLibrary& library, const std::string& id,
                                                             const VolumeInput& input) {
  auto talk = TRY(start_conversation(library, id, input.name, input.bytes, input.context));
  auto visit = std::make_unique<WorkerVolumeSession>(std::move(talk));
  TRY(visit->fill_list(input));
  return visit;
}

}  // namespace isoextract::plugin_host
