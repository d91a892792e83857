#include "plugin_host/detail/plugin_worker.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <mutex>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include <particle_plugin.h>
#include <volume_plugin.h>
#include "base/buffer.hpp"
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "field/samples.hpp"
#include "plugin_host/detail/plugin_messages.hpp"
#include "plugin_host/detail/volume_request.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "sandbox/message.hpp"
#include "sandbox/shared_memory.hpp"

namespace isoextract::plugin_host {
namespace {

using sandbox::Mapping;
using sandbox::MessageReader;
using sandbox::MessageWriter;

// Sends a signed number as the 64 bits of an unsigned one.
std::uint64_t bits(std::int64_t number) { return static_cast<std::uint64_t>(number); }

// The program at the other end of the socket. Calls fail once the program has ended.
class Program {
 public:
  explicit Program(int socket) : socket_(socket) {}

  [[nodiscard]] bool tell(const MessageWriter& message) const { return sandbox::send_message(socket_, message); }
  [[nodiscard]] std::optional<sandbox::ReceivedMessage> hear() const { return sandbox::receive_message(socket_); }

  [[nodiscard]] bool send(std::span<const std::byte> bytes) const { return sandbox::send_bytes(socket_, bytes); }

  bool reserve(std::uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    return ask(say(MessageKind::reserve).number(bytes)).has_value();
  }

  void release(std::uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    static_cast<void>(tell(say(MessageKind::release).number(bytes)));
  }

  void* allocate(std::uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    const auto granted = ask(say(MessageKind::allocate).number(bytes));
    if (!granted) return nullptr;
    Mapping memory(granted->descriptor.get(), bytes, Mapping::Access::write);
    if (memory.bytes().empty()) return nullptr;
    memories_.push_back(std::move(memory));
    return memories_.back().bytes().data();
  }

  // Returns where `bytes` at `from` are in shared memory, if they are.
  [[nodiscard]] std::optional<SharedPlace> place_of(const void* from, std::uint64_t bytes) const {
    const auto begin = reinterpret_cast<std::uintptr_t>(from);
    for (std::size_t i = 0; i < memories_.size(); ++i) {
      const auto start = reinterpret_cast<std::uintptr_t>(memories_[i].bytes().data());
      const std::uint64_t size = memories_[i].bytes().size();
      if (begin >= start && begin - start <= size && bytes <= size - (begin - start)) return {{i, begin - start}};
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::optional<sandbox::ReceivedMessage> ask(const MessageWriter& question) const {
    if (!tell(question)) return std::nullopt;
    auto answer = hear();
    if (!answer || answer->message.number() != static_cast<std::uint64_t>(MessageKind::granted)) return std::nullopt;
    return answer;
  }

  int socket_;
  std::mutex mutex_;
  std::vector<Mapping> memories_;
};

MessageWriter failure(const char* text, std::int32_t failure = ISOEXTRACT_READ_FAILED) {
  return std::move(say(MessageKind::failed).text(plugin_text(text)).number(bits(failure)));
}

// Volumes.

using VolumePlugin = isoextract_volume_plugin_v4;

void add_grid(MessageWriter& message, const isoextract_volume_grid& grid) {
  message.text(plugin_text(grid.name)).text(plugin_text(grid.type_name)).text(plugin_text(grid.world_space));
  message.text(plugin_text(grid.length_unit)).text(plugin_text(grid.component_names)).text(plugin_text(grid.time_unit));
  message.number(bits(grid.sample_type)).number(bits(grid.kind)).number(bits(grid.is_sparse));
  message.number(bits(grid.is_sampled)).number(bits(grid.has_placement));
  for (const std::uint64_t dim : grid.dims) message.number(dim);
  for (const double entry : grid.index_to_world) message.real(entry);
  message.real(grid.slope).real(grid.intercept).number(grid.components).number(grid.volumes);
  message.number(grid.volume_times == nullptr ? 0 : 1);
  for (std::uint64_t i = 0; grid.volume_times != nullptr && i < grid.volumes; ++i) message.real(grid.volume_times[i]);
  const std::size_t label_count = grid.labels == nullptr ? 0 : grid.label_count;
  message.number(label_count);
  for (std::size_t i = 0; i < label_count; ++i) {
    const isoextract_volume_label& label = grid.labels[i];
    message.number(bits(label.value)).text(plugin_text(label.name)).number(bits(label.has_color));
    for (const double channel : label.color) message.real(channel);
  }
  message.number(bits(grid.has_counts)).number(grid.active_voxels);
  for (int axis = 0; axis < 3; ++axis) message.number(bits(grid.active_min[axis])).number(bits(grid.active_max[axis]));
}

MessageWriter listed(const isoextract_volume_list& list) {
  MessageWriter message = say(MessageKind::listed);
  message.number(list.format == nullptr ? 0 : 1).text(plugin_text(list.format));
  message.text(plugin_text(list.creator)).text(plugin_text(list.note));
  message.number(list.grids == nullptr ? 0 : list.count);
  for (std::size_t i = 0; list.grids != nullptr && i < list.count; ++i) add_grid(message, list.grids[i]);
  message.number(list.files == nullptr ? 0 : list.file_count);
  for (std::size_t i = 0; list.files != nullptr && i < list.file_count; ++i) message.text(plugin_text(list.files[i]));
  return message;
}

// Stores the blocks in shared memory, and copies values that the plug-in has elsewhere. Returns nothing if the program
// grants no memory.
std::optional<SharedPlace> copy_blocks_to_shared_memory(Program& program, const isoextract_sparse_samples& samples) {
  const auto type = sample_type_of(samples.sample_type);
  if (!type) return std::nullopt;
  constexpr std::uint64_t kSamples =
      std::uint64_t{field::SparseBlock::kSize} * field::SparseBlock::kSize * field::SparseBlock::kSize;
  const std::uint64_t block_bytes = kSamples * field::sample_size(*type);
  const std::span blocks(samples.blocks, samples.block_count);
  std::byte* copies = nullptr;  // copies of all blocks' values, if the plug-in has them elsewhere
  const auto is_shared = [&](const auto& block) { return program.place_of(block.values, block_bytes).has_value(); };
  if (!std::ranges::all_of(blocks, is_shared)) {
    copies = static_cast<std::byte*>(program.allocate(blocks.size() * block_bytes));
    if (copies == nullptr) return std::nullopt;
  }
  auto* shared = static_cast<SharedBlock*>(program.allocate(blocks.size() * sizeof(SharedBlock)));
  if (shared == nullptr) return std::nullopt;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const void* values = blocks[i].values;
    if (copies != nullptr) values = std::memcpy(copies + i * block_bytes, values, block_bytes);
    const auto place = program.place_of(values, block_bytes);
    const std::int32_t* origin = blocks[i].origin;
    shared[i] = {{origin[0], origin[1], origin[2]}, static_cast<std::uint32_t>(place->memory), place->offset};
  }
  return program.place_of(shared, blocks.size() * sizeof(SharedBlock));
}

std::optional<SharedPlace> share_tiles(Program& program, const isoextract_sparse_samples& samples) {
  const std::uint64_t bytes = samples.tile_count * sizeof(isoextract_sparse_tile);
  void* shared = program.allocate(bytes);
  if (shared == nullptr) return std::nullopt;
  std::memcpy(shared, samples.tiles, bytes);
  return program.place_of(shared, bytes);
}

// Returns nothing if the program grants no memory.
std::optional<MessageWriter> grid_opened(Program& program, const isoextract_volume_samples& given) {
  MessageWriter message = say(MessageKind::grid_opened);
  message.text(plugin_text(given.note)).number(given.parts_read).number(given.parts);
  message.number(given.sparse == nullptr ? 0 : 1);
  if (given.sparse == nullptr) return message;
  const isoextract_sparse_samples& samples = *given.sparse;
  message.number(bits(samples.sample_type)).real(samples.background).number(samples.active_voxels);
  for (int axis = 0; axis < 3; ++axis) {
    message.number(bits(samples.active_min[axis])).number(bits(samples.active_max[axis]));
  }
  SharedPlace blocks;
  SharedPlace tiles;
  if (samples.block_count > 0) {
    const auto place = copy_blocks_to_shared_memory(program, samples);
    if (!place) return std::nullopt;
    blocks = *place;
  }
  if (samples.tile_count > 0) {
    const auto place = share_tiles(program, samples);
    if (!place) return std::nullopt;
    tiles = *place;
  }
  message.number(samples.block_count).number(blocks.memory).number(blocks.offset);
  message.number(samples.tile_count).number(tiles.memory).number(tiles.offset);
  return message;
}

class HostCalls {
 public:
  explicit HostCalls(Program& program)
      : host_{&program,
              [](void* self, std::uint64_t bytes) { return static_cast<Program*>(self)->reserve(bytes) ? 0 : 1; },
              [](void* self, std::uint64_t bytes) { static_cast<Program*>(self)->release(bytes); },
              [](void* self, std::uint64_t bytes) { return static_cast<Program*>(self)->allocate(bytes); },
              [](void* /*self*/) { return 0; }} {}  // the program kills this process to cancel
  [[nodiscard]] const isoextract_plugin_host& get() const { return host_; }

 private:
  isoextract_plugin_host host_;
};

// The program's request, with the texts that it refers to.
struct HeardRequest {
  VolumeInput input;
  std::vector<const char*> files;
};

// Returns nothing if the message is no valid request.
std::optional<HeardRequest> heard_request(MessageReader& message) {
  HeardRequest heard;
  VolumeInput& input = heard.input;
  input.path = message.text();
  const bool is_file = message.number() != 0;
  const std::string start = message.text();
  if (is_file) {
    const auto bytes = std::as_bytes(std::span(start));
    input.start.emplace(bytes.begin(), bytes.end());
  }
  const std::uint64_t file_count = message.number();
  if (file_count > message.left()) return std::nullopt;
  for (std::uint64_t i = 0; i < file_count; ++i) input.files.push_back(message.text());
  input.volume = message.number();
  input.level = message.number();
  for (double& spacing : input.spacing) spacing = message.real();
  input.resamples = message.number() != 0;
  if (!message.is_whole()) return std::nullopt;
  for (const std::string& file : input.files) heard.files.push_back(file.c_str());
  return heard;
}

VolumeSelection heard_selection(MessageReader& message) {
  VolumeSelection selection;
  selection.grid = static_cast<std::size_t>(message.number());
  selection.volume = message.number();
  selection.component = static_cast<std::int64_t>(message.number());
  for (std::uint64_t& first : selection.first) first = message.number();
  for (std::uint64_t& count : selection.count) count = message.number();
  selection.box_bytes = message.number();
  return selection;
}

// Reads the samples that a message chooses and answers. Returns false if that failed.
bool open_grid(const VolumePlugin& plugin, Program& program, const isoextract_plugin_host& host,
               const isoextract_volume_list& list, sandbox::ReceivedMessage& choice) {
  const VolumeSelection chosen = heard_selection(choice.message);
  const Mapping box(choice.descriptor.get(), chosen.box_bytes, Mapping::Access::write);
  const isoextract_volume_selection selection = selection_of(chosen, box.bytes().data());
  isoextract_volume_samples samples{};
  if (const int failed = plugin.open(&list, &selection, &host, &samples); failed != 0) {
    static_cast<void>(program.tell(failure(plugin.error_text(), failed)));
    return false;
  }
  bool is_told = false;
  if (chosen.box_bytes == 0) {
    const auto message = grid_opened(program, samples);
    is_told = program.tell(message ? *message : failure("not enough memory for its samples")) && message;
  } else {
    MessageWriter message = say(MessageKind::box_opened);
    message.text(plugin_text(samples.note)).number(samples.parts_read).number(samples.parts).number(samples.filled);
    is_told = program.tell(message);
  }
  plugin.free_samples(&samples);
  return is_told;
}

void read_volume(const VolumePlugin& plugin, int socket) {
  Program program(socket);
  auto job = program.hear();
  if (!job || job->message.number() != static_cast<std::uint64_t>(MessageKind::list_volume)) return;
  const auto wanted = heard_request(job->message);
  if (!wanted) return;
  if (const auto& start = wanted->input.start) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(start->data());
    if (plugin.probe(bytes, start->size(), wanted->input.path.c_str()) == 0) {
      static_cast<void>(program.tell(say(MessageKind::wrong_format)));
      return;
    }
  }
  const HostCalls host(program);
  isoextract_volume_list list{};
  const VolumeRequest request(wanted->input, wanted->files);
  if (const int failed = plugin.list(&request.get(), &host.get(), &list); failed != 0) {
    static_cast<void>(program.tell(failure(plugin.error_text(), failed)));
    return;
  }
  if (!program.tell(listed(list))) return;
  for (auto choice = program.hear(); choice; choice = program.hear()) {
    if (choice->message.number() != static_cast<std::uint64_t>(MessageKind::open_grid)) return;
    if (!open_grid(plugin, program, host.get(), list, *choice)) return;
  }
}

// Particles.

using ParticlePlugin = isoextract_particle_plugin_v3;

MessageWriter particles_opened(const isoextract_particle_file& file) {
  MessageWriter message = say(MessageKind::particles_opened);
  message.number(file.particles).number(file.frames).number(file.held_bytes);
  message.text(plugin_text(file.frame_name)).text(plugin_text(file.length_unit));
  message.number(file.quantities == nullptr ? 0 : 1).number(file.quantity_count);
  for (std::size_t i = 0; file.quantities != nullptr && i < file.quantity_count; ++i) {
    const isoextract_particle_quantity& quantity = file.quantities[i];
    message.text(plugin_text(quantity.name)).text(plugin_text(quantity.type_name));
    message.number(quantity.components).number(bits(quantity.is_numeric)).number(bits(quantity.kind));
  }
  return message;
}

// Sends as many numbers as the plug-in announced. Uses the socket, as its cached buffers are faster than fresh shared
// pages. Returns false if the program has ended.
template <class Number, class Fill>
bool send_filled(const ParticlePlugin& plugin, const Program& program, std::uint64_t particles,
                 std::uint64_t components, Fill&& fill) {
  const auto count = checked_product(particles, components);
  if (!count || !checked_product(*count, std::uint64_t{sizeof(Number)})) {
    return program.tell(failure("the plug-in announces more numbers than 64 bits can count"));
  }
  Buffer<Number> numbers;
  try {
    numbers = Buffer<Number>(static_cast<std::size_t>(*count));
  } catch (const std::bad_alloc&) {
    return program.tell(failure("not enough memory for its particles"));
  }
  if (fill(numbers.data()) != 0) return program.tell(failure(plugin.error_text()));
  return program.tell(say(MessageKind::filled).number(numbers.size_bytes())) &&
         program.send(std::as_bytes(numbers.span()));
}

void read_particles_of(const ParticlePlugin& plugin, int socket) {
  const Program program(socket);
  auto job = program.hear();
  if (!job || job->message.number() != static_cast<std::uint64_t>(MessageKind::open_particles)) return;
  const std::string path = job->message.text();
  const bool has_grid = job->message.number() != 0;
  const std::string grid = job->message.text();
  isoextract_particle_file file{};
  if (plugin.open(path.c_str(), has_grid ? grid.c_str() : nullptr, job->message.number(), &file) != 0) {
    static_cast<void>(program.tell(failure(plugin.error_text())));
    return;
  }
  if (!program.tell(particles_opened(file))) return;
  while (auto wanted = program.hear()) {
    const auto what = static_cast<MessageKind>(wanted->message.number());
    bool sent = false;
    if (what == MessageKind::positions) {
      sent = send_filled<double>(plugin, program, file.particles, 3,
                                 [&](double* values) { return plugin.positions(&file, values); });
    } else if (what == MessageKind::quantity) {
      const auto index = static_cast<std::size_t>(wanted->message.number());
      if (index >= file.quantity_count) return;
      sent = send_filled<float>(plugin, program, file.particles, file.quantities[index].components,
                                [&](float* values) { return plugin.quantity(&file, index, values); });
    }
    if (!sent) return;
  }
}

template <class Plugin>
sandbox::ChildWork work_of(const PluginKind& kind, std::span<const std::string> words,
                           std::string (*greeting)(const Plugin&), void (*read)(const Plugin&, int)) {
  const auto opened = open_plugin(kind, words[1], words[2]);
  if (!opened) return {opened.error().what, {}, opened.error().advice};
  const auto* plugin = static_cast<const Plugin*>(*opened);
  return {greeting(*plugin), [plugin, read](int socket) { read(*plugin, socket); }, {}};
}

}  // namespace

sandbox::ChildWork make_plugin_work(std::span<const std::string> words) {
  if (words.size() != 3) return {"got arguments that it does not know", {}, {}};
  if (words[0] == kVolumePlugins.function) {
    return work_of<VolumePlugin>(
        kVolumePlugins, words, [](const VolumePlugin& plugin) { return plugin_text(plugin.format); }, read_volume);
  }
  if (words[0] == kParticlePlugins.function) {
    return work_of<ParticlePlugin>(
        kParticlePlugins, words, [](const ParticlePlugin&) { return std::string(); }, read_particles_of);
  }
  return {"is of a kind that reads no files", {}, {}};
}

}  // namespace isoextract::plugin_host
