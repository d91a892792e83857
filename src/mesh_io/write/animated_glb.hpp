// One .glb whose nodes are the frames of a sequence, each shown in its time only.
//
// glTF has no visibility; what every viewer knows is scale. Each frame's node has a channel of STEP-interpolated scale:
// 0 from the beginning of the time line on, 1 while it is shown, 0 afterwards. A sampler holds its first and last value
// outside of its times, so three keys are all that a frame needs. Programs that play nothing show the node that has a
// scale of 1 of its own, the first.
//
// The container begins with its JSON, which says where everything is and so is known at the end. Room is left for it,
// and what it does not need stays spaces, as the container pads it. Where the room was too small, or is more than all
// data, the data moves once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "files/output_file.hpp"
#include "mesh_io/write/gltf_model.hpp"
#include "mesh_io/write/gltf_part.hpp"
#include "mesh_io/write/json_lists.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"

namespace isoextract::mesh_io {

class AnimatedGlb {
 public:
  // Of at most `largest` bytes.
  AnimatedGlb(std::filesystem::path path, std::uint64_t largest, std::string placement)
      : path_(std::move(path)), largest_(largest), model_(std::move(placement)) {}

  // Opens the file, once; the calls below do so too.
  [[nodiscard]] Result<void> open();

  // Shows a frame, of which not all parts may be without triangles, from `time` on until there is another or none.
  // False where the file would become too large; then all is as before. The first frame leaves room for
  // `frames_to_come` like it.
  [[nodiscard]] Result<bool> add(const std::string& name, std::span<const GltfPart> parts, float time,
                                 std::uint64_t frames_to_come);
  void show_none(float time);

  // Writes all that is left but does not commit. The time line ends at `end`.
  [[nodiscard]] Result<void> finish(float end);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] files::OutputFile& file() { return *file_; }
  [[nodiscard]] Notes take_notes() { return model_.take_notes(); }

 private:
  static constexpr float kStillShown = std::numeric_limits<float>::infinity();
  struct Key {
    int node = 0;
    float shown = 0;
    float hidden = kStillShown;
  };

  // Of the whole file with so many frames, at most; the JSON is what is there without animation.
  [[nodiscard]] std::uint64_t bytes_with(std::uint64_t json, std::uint64_t binary, std::uint64_t frames) const;
  [[nodiscard]] Result<void> leave_room(std::uint64_t json_of_frame, std::uint64_t binary_of_frame,
                                        std::uint64_t frames);
  [[nodiscard]] std::vector<float> times_of(const Key& key, float end) const;
  [[nodiscard]] Result<void> write_keys(float end);
  [[nodiscard]] std::string describe();

  std::filesystem::path path_;
  std::uint64_t largest_;
  std::optional<files::OutputFile> file_;
  std::uint64_t room_ = 0;    // for the JSON
  std::uint64_t binary_ = 0;  // bytes of data
  GltfModel model_;
  JsonLists json_;
  std::vector<Key> keys_;
};

}  // namespace isoextract::mesh_io
