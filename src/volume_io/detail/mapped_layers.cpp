#include "volume_io/detail/mapped_layers.hpp"

#include <atomic>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/byte_size.hpp"
#include "field/sample_layers.hpp"
#include "files/file_window.hpp"

namespace isoextract::volume_io {
namespace {

class MappedLayers final : public field::SampleLayers {
 public:
  MappedLayers(files::InputFile file, std::uint64_t offset, std::uint64_t layer_bytes)
      : file_(std::move(file)), offset_(offset), layer_bytes_(layer_bytes) {}

  [[nodiscard]] Result<std::unique_ptr<Window>> open(int layers) const override {
    auto window = files::FileWindow::make(file_, layer_bytes_ * static_cast<std::uint64_t>(layers));
    if (!window) return tl::unexpected(no_room(layers));
    return std::make_unique<LayerWindow>(*this, std::move(*window));
  }

  [[nodiscard]] const std::atomic<bool>& lost() const { return lost_; }

 private:
  class LayerWindow final : public Window {
   public:
    LayerWindow(const MappedLayers& layers, files::FileWindow window) : layers_(layers), window_(std::move(window)) {}
    LayerWindow(const LayerWindow&) = delete;
    LayerWindow& operator=(const LayerWindow&) = delete;
    ~LayerWindow() override { note_loss(); }

    [[nodiscard]] Result<const void*> move_to(int begin, int end) override {
      note_loss();
      const std::uint64_t first = layers_.layer_bytes_ * static_cast<std::uint64_t>(begin);
      const std::uint64_t bytes = layers_.layer_bytes_ * static_cast<std::uint64_t>(end - begin);
      const std::byte* samples = window_.move_to(layers_.offset_ + first, bytes);
      if (samples == nullptr) return tl::unexpected(layers_.no_room(end - begin));
      return samples;
    }

   private:
    void note_loss() const {
      if (window_.lost()) layers_.lost_.store(true, std::memory_order_release);
    }

    const MappedLayers& layers_;
    files::FileWindow window_;
  };

  [[nodiscard]] Error no_room(int layers) const {
    return allocation_error(fmt::format("{}: mapping {} layers of samples ({}) failed", file_.name(), layers,
                                        format_byte_size(layer_bytes_ * static_cast<std::uint64_t>(layers))));
  }

  files::InputFile file_;
  std::uint64_t offset_;
  std::uint64_t layer_bytes_;
  mutable std::atomic<bool> lost_{false};
};

}  // namespace

std::optional<field::DenseSamples> map_layers(const SampleSource& source, field::SampleType type,
                                              const glm::ivec3& dims, const Context& context, Notes& notes) {
  const auto limit = address_space_limit();
  if (!limit || !is_mappable(source)) return std::nullopt;
  const SamplePiece& piece = source.pieces.front();
  const auto file = files::InputFile::open(piece.path, context);
  if (!file || piece.offset > file->size() || source.bytes > file->size() - piece.offset) return std::nullopt;
  const auto layers =
      std::make_shared<const MappedLayers>(*file, piece.offset, source.bytes / static_cast<std::uint64_t>(dims.z));
  const auto window = layers->open(1);
  if (!window || !(*window)->move_to(0, 1)) return std::nullopt;
  file->add_bytes_read(source.bytes);
  context.progress().begin("reading", source.bytes);
  context.progress().advance(source.bytes);
  notes.push_back({NoteId::samples_in_windows,
                   fmt::format("the address space of the process is limited to {}, so the program maps a few layers of "
                               "the {} of samples at a time",
                               format_byte_size(*limit), format_byte_size(source.bytes))});
  field::DenseSamples samples;
  samples.type = type;
  samples.dims = dims;
  samples.loss = &layers->lost();
  samples.layers = layers.get();
  samples.owner = layers;
  return samples;
}

bool fills_address_space(const SampleSource& source) {
  const auto left = address_space_left();
  return left && source.bytes > *left / 2;
}

}  // namespace isoextract::volume_io
