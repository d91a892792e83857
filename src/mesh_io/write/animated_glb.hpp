// Writes one .glb whose nodes are the frames of a sequence, each visible only during its time.
//
// glTF has no visibility, but every viewer supports scale. Each frame's node has a channel of STEP-interpolated scale:
// 0 from the start of the time line, 1 while the frame is shown, 0 afterwards.
// A sampler holds its first and last value outside of its times, so three keys per frame (four for the last) are
// enough. Programs that do not play animations show the first frame, the only node whose own scale is 1.
//
// A GLB begins with its JSON, which is complete only after the last frame. The writer reserves space for it and fills
// the unused rest with spaces, the padding that the container prescribes.
// If the space was too small, or its unused rest is larger than all data, the data moves once.
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
  // The file gets at most `largest` bytes.
  AnimatedGlb(std::filesystem::path path, std::uint64_t largest, std::string placement)
      : path_(std::move(path)), largest_(largest), model_(std::move(placement)) {}

  // Opens the file unless it is open. The functions below do so as well.
  [[nodiscard]] Result<void> open();

  // Adds a frame that is shown from `time` (seconds) until the next add() or hide_all(). At least one part must have
  // triangles.
  // Returns false, and changes nothing, if the file would become too large. The first frame reserves JSON space for
  // `frames_to_come` similar frames.
  [[nodiscard]] Result<bool> add(const std::string& name, std::span<const GltfPart> parts, float time,
                                 std::uint64_t frames_to_come);
  void hide_all(float time);

  // Writes the rest of the file but does not commit it. The time line ends at `end` seconds.
  [[nodiscard]] Result<void> finish(float end);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] files::OutputFile& file() { return *file_; }
  [[nodiscard]] Notes release_notes() { return model_.release_notes(); }

 private:
  static constexpr float kStillShown = std::numeric_limits<float>::infinity();
  struct Key {
    int node = 0;
    float shown = 0;
    float hidden = kStillShown;
  };

  // Returns an upper bound of the file's bytes with that many frames. `json` counts the JSON without the animation.
  [[nodiscard]] std::uint64_t bytes_with(std::uint64_t json, std::uint64_t binary, std::uint64_t frames) const;
  [[nodiscard]] Result<void> reserve_json_space(std::uint64_t json_of_frame, std::uint64_t binary_of_frame,
                                                std::uint64_t frames);
  [[nodiscard]] std::vector<float> times_of(const Key& key, float end) const;
  [[nodiscard]] Result<void> write_keys(float end);
  [[nodiscard]] std::string describe();

  std::filesystem::path path_;
  std::uint64_t largest_;
  std::optional<files::OutputFile> file_;
  std::uint64_t room_ = 0;    // bytes reserved for the JSON
  std::uint64_t binary_ = 0;  // bytes of data
  GltfModel model_;
  JsonLists json_;
  std::vector<Key> keys_;
};

}  // namespace isoextract::mesh_io
