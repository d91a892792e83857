#include "mesh_io/write/animated_glb.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "base/printable_json.hpp"
#include "mesh_io/write/glb_container.hpp"

namespace isoextract::mesh_io {
namespace {

// Upper bounds of the JSON bytes for a frame's animation (node number in the scene, times, channel, sampler) and for
// the rest of the file.
constexpr std::uint64_t kJsonOfKey = 320;
constexpr std::uint64_t kJsonOfFile = 2048;

// Every sequence of scales that a frame needs is a range of this list.
constexpr float kScales[][3] = {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 1, 1}, {1, 1, 1}};
constexpr std::size_t kHiddenAgain = 0;    // 0 1 0 0
constexpr std::size_t kShownToTheEnd = 4;  // 0 1 1

// Key times of a frame: 0, shown, hidden, and the end of the time line.
constexpr std::uint64_t kMaxTimes = 4;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

Result<void> write_spaces(files::OutputFile& file, std::uint64_t count) {
  const std::string spaces(std::min<std::uint64_t>(count, 1 << 16), ' ');
  Result<void> written;
  for (std::uint64_t left = count; left > 0 && written;) {
    const auto size = std::min<std::uint64_t>(left, spaces.size());
    written = file.write(std::string_view(spaces).substr(0, size));
    left -= size;
  }
  return written;
}

}  // namespace

Result<void> AnimatedGlb::open() {
  if (file_) return {};
  auto opened = files::OutputFile::create(path_);
  if (!opened) return tl::unexpected<Error>(std::move(opened.error()));
  file_ = std::move(*opened);
  return {};
}

std::uint64_t AnimatedGlb::bytes_with(std::uint64_t json, std::uint64_t binary, std::uint64_t frames) const {
  const std::uint64_t text = gltf_aligned(json + frames * kJsonOfKey + kJsonOfFile);
  // Only the last frame has four times.
  const std::uint64_t keys = frames * (kMaxTimes - 1) * sizeof(float) + sizeof(float) + sizeof kScales;
  return glb_bytes(std::max(text, room_), binary + keys);
}

Result<bool> AnimatedGlb::add(const std::string& name, std::span<const GltfPart> parts, float time,
                              std::uint64_t frames_to_come) {
  std::uint64_t bytes = 0;
  for (const GltfPart& part : parts) bytes += part.bytes();
  if (bytes_with(json_.bytes(), binary_ + bytes, keys_.size() + 1) > largest_) return false;

  // Works on a copy, so that a frame which does not fit changes nothing. The copy is small: flush() emptied model_.
  GltfModel model = model_;
  const int node = model.add_frame(name, parts, !keys_.empty());
  bool fits = false;
  std::uint64_t json_of_frame = 0;
  model.flush([&](const nlohmann::json& document) {
    json_of_frame = printable_json(document.dump()).size();
    fits = bytes_with(json_.bytes() + json_of_frame, model.binary_bytes(), keys_.size() + 1) <= largest_;
    if (fits) json_.add(document);
  });
  if (!fits) return false;
  model_ = std::move(model);

  auto written = open();
  if (written && keys_.empty()) written = reserve_json_space(json_of_frame, bytes, frames_to_come);
  hide_all(time);
  keys_.push_back({node, time});
  for (const GltfPart& part : parts) {
    if (written) written = write_part(part, *file_);
  }
  binary_ += bytes;
  if (!written) return tl::unexpected<Error>(std::move(written.error()));
  return true;
}

void AnimatedGlb::hide_all(float time) {
  if (!keys_.empty() && keys_.back().hidden == kStillShown) keys_.back().hidden = time;
}

// Reserves a quarter more JSON per following frame than the first one needs, since numbers get longer.
Result<void> AnimatedGlb::reserve_json_space(std::uint64_t json_of_frame, std::uint64_t binary_of_frame,
                                             std::uint64_t frames) {
  const std::uint64_t each = json_of_frame + json_of_frame / 4 + kJsonOfKey;
  const std::uint64_t left = largest_ - bytes_with(json_of_frame, binary_of_frame, 1);
  const std::uint64_t wanted = std::min(frames, largest_ / each) * each;
  room_ = gltf_aligned(json_of_frame + kJsonOfKey + kJsonOfFile) +
          std::min(wanted, left / 4) / kGltfAlignment * kGltfAlignment;
  return write_spaces(*file_, glb_bytes(room_, 0) + kGlbChunkHeadBytes);
}

std::vector<float> AnimatedGlb::times_of(const Key& key, float end) const {
  std::vector<float> times{0};
  if (key.shown > 0) times.push_back(key.shown);
  if (key.hidden != kStillShown) times.push_back(key.hidden);
  // The last time of any sampler ends the animation.
  if (&key == &keys_.back()) times.push_back(end);
  return times;
}

Result<void> AnimatedGlb::write_keys(float end) {
  const auto view = [&](std::uint64_t bytes) {
    const auto number =
        json_.add("bufferViews", nlohmann::json{{"buffer", 0}, {"byteOffset", binary_}, {"byteLength", bytes}}.dump());
    binary_ += bytes;
    return number;
  };
  const auto scales_view = view(sizeof kScales);
  auto written = file_->write(std::as_bytes(std::span(kScales)));

  std::vector<float> all_times;
  all_times.reserve(kMaxTimes * keys_.size());
  for (const Key& key : keys_) {
    const std::vector<float> times = times_of(key, end);
    all_times.insert(all_times.end(), times.begin(), times.end());
  }
  const auto times_view = view(all_times.size() * sizeof(float));
  if (written) written = file_->write(std::as_bytes(std::span(all_times)));

  JsonLists animation;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> scales;  // accessor numbers, by first index and count
  const auto accessor = [&](const nlohmann::json& description) { return json_.add("accessors", description.dump()); };
  const auto scales_of = [&](std::size_t first, std::size_t count) {
    const auto [found, is_new] = scales.try_emplace({first, count});
    if (is_new) {
      found->second = accessor({{"bufferView", scales_view},
                                {"byteOffset", first * sizeof kScales[0]},
                                {"componentType", TINYGLTF_COMPONENT_TYPE_FLOAT},
                                {"count", count},
                                {"type", "VEC3"}});
    }
    return found->second;
  };
  const auto number = [](float time) { return nlohmann::json(static_cast<double>(time)); };
  std::size_t at = 0;
  for (const Key& key : keys_) {
    const std::size_t count = times_of(key, end).size();
    const auto input = accessor({{"bufferView", times_view},
                                 {"byteOffset", at * sizeof(float)},
                                 {"componentType", TINYGLTF_COMPONENT_TYPE_FLOAT},
                                 {"count", count},
                                 {"type", "SCALAR"},
                                 {"min", nlohmann::json::array({number(all_times[at])})},
                                 {"max", nlohmann::json::array({number(all_times[at + count - 1])})}});
    at += count;
    const std::size_t first = (key.hidden == kStillShown ? kShownToTheEnd : kHiddenAgain) + (key.shown > 0 ? 0 : 1);
    const auto sampler = animation.add("samplers", fmt::format(R"({{"input":{},"interpolation":"STEP","output":{}}})",
                                                               input, scales_of(first, count)));
    animation.add("channels",
                  fmt::format(R"({{"sampler":{},"target":{{"node":{},"path":"scale"}}}})", sampler, key.node));
  }
  animation.add(nlohmann::json::object({{"name", "sequence"}}));
  json_.add("animations", animation.take());
  return written;
}

std::string AnimatedGlb::describe() {
  JsonLists scene;
  for (const Key& key : keys_) scene.add("nodes", fmt::to_string(key.node));
  json_.add("scenes", scene.take());
  json_.add(nlohmann::json::object({{"scene", 0}}));
  if (binary_ > 0) json_.add("buffers", nlohmann::json::object({{"byteLength", binary_}}).dump());
  if (const nlohmann::json unpacked = model_.unpacked_buffer(); !unpacked.is_null()) {
    json_.add("buffers", unpacked.dump());
  }
  // Adds the asset if there was no frame.
  model_.flush([&](const nlohmann::json& document) { json_.add(document); });
  std::string json = json_.take();
  pad_glb_json(json);
  return json;
}

Result<void> AnimatedGlb::finish(float end) {
  TRY(open());
  if (keys_.empty()) {
    const std::string json = describe();
    auto written = file_->write(glb_start(json.size(), 0));
    return written ? file_->write(json) : written;
  }
  TRY(write_keys(end));
  const std::string json = describe();
  if (json.size() > room_ || room_ - json.size() > binary_) {
    const std::uint64_t before = std::exchange(room_, json.size());
    TRY(file_->move_end(glb_bytes(before, 0), glb_bytes(room_, 0)));
  }
  if (const std::uint64_t bytes = glb_bytes(room_, binary_); bytes > largest_) {
    return fail(ErrorCode::output,
                fmt::format("{}: the file needs {} bytes; the limit is {} bytes", path_.string(), bytes, largest_));
  }
  auto written = file_->overwrite(0, bytes_of(glb_start(room_, binary_) + json));
  return written ? file_->overwrite(glb_bytes(room_, 0), bytes_of(glb_binary_head(binary_))) : written;
}

}  // namespace isoextract::mesh_io
