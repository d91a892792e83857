// Plays an animated .glb as a viewer does, strictly by the specification.
#pragma once

#include <cstring>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/temp_folder.hpp"
#include "unit/mesh_io/glb_chunks.hpp"

namespace isoextract::test {

class PlayedGlb {
 public:
  explicit PlayedGlb(const std::filesystem::path& path) : chunks_(take_apart(read_bytes(path))) {
    if (!model().contains("animations")) return;
    const auto& animation = model()["animations"].at(0);
    EXPECT_EQ(model()["animations"].size(), 1U);
    for (const auto& channel : animation["channels"]) {
      EXPECT_EQ(channel["target"]["path"], "scale");
      const auto& sampler = animation["samplers"].at(channel["sampler"].get<std::size_t>());
      EXPECT_EQ(sampler["interpolation"], "STEP");
      Track track{channel["target"]["node"].get<std::size_t>(), floats(sampler["input"]), floats(sampler["output"])};
      EXPECT_EQ(track.scales.size(), 3 * track.times.size());
      for (std::size_t k = 1; k < track.times.size(); ++k) EXPECT_LT(track.times[k - 1], track.times[k]);
      const auto& input = model()["accessors"].at(sampler["input"].get<std::size_t>());
      EXPECT_EQ(input["min"][0].get<float>(), track.times.front());
      EXPECT_EQ(input["max"][0].get<float>(), track.times.back());
      duration_ = std::max(duration_, track.times.back());
      tracks_.push_back(std::move(track));
    }
  }

  [[nodiscard]] const nlohmann::json& model() const { return chunks_.model; }
  // Returns the length that players give it: the time of the last key.
  [[nodiscard]] float duration() const { return duration_; }
  [[nodiscard]] const std::string& binary() const { return chunks_.binary; }

  // Returns the names of the visible nodes at a time, by STEP interpolation with clamping (glTF 2.0, appendix C).
  [[nodiscard]] std::set<std::string> seen_at(double time) const {
    std::set<std::string> seen = seen_at_rest();
    for (const Track& track : tracks_) {
      std::size_t key = 0;
      while (key + 1 < track.times.size() && track.times[key + 1] <= time) ++key;
      const float scale = track.scales[3 * key];
      EXPECT_TRUE(scale == 0 || scale == 1);
      EXPECT_TRUE(scale == track.scales[3 * key + 1] && scale == track.scales[3 * key + 2]);
      const std::string name = name_of(track.node);
      seen.erase(name);
      if (scale == 1) seen.insert(name);
    }
    return seen;
  }

  // Returns the names of the visible nodes if the animation is not played.
  [[nodiscard]] std::set<std::string> seen_at_rest() const {
    std::set<std::string> seen;
    for (const auto& node : model()["scenes"][0].value("nodes", nlohmann::json::array())) {
      const auto& described = model()["nodes"].at(node.get<std::size_t>());
      const auto scale = described.value("scale", std::vector<double>{1, 1, 1});
      EXPECT_TRUE(scale == std::vector<double>(3, 1) || scale == std::vector<double>(3, 0));
      if (scale[0] == 1) seen.insert(name_of(node.get<std::size_t>()));
    }
    return seen;
  }

 private:
  struct Track {
    std::size_t node;
    std::vector<float> times;
    std::vector<float> scales;
  };

  [[nodiscard]] std::string name_of(std::size_t node) const {
    return model()["nodes"].at(node).at("name").get<std::string>();
  }

  [[nodiscard]] std::vector<float> floats(const nlohmann::json& index) const {
    const auto& accessor = model()["accessors"].at(index.get<std::size_t>());
    const auto& view = model()["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    EXPECT_EQ(accessor["componentType"], 5126);
    std::vector<float> values(accessor["count"].get<std::size_t>() * (accessor["type"] == "VEC3" ? 3 : 1));
    const std::size_t inside = accessor.value("byteOffset", std::size_t{0});
    const std::size_t offset = view.value("byteOffset", std::size_t{0}) + inside;
    const std::size_t bytes = values.size() * sizeof(float);
    EXPECT_LE(inside + bytes, view["byteLength"].get<std::size_t>());
    if (offset + bytes > binary().size()) throw std::runtime_error("an accessor ends behind the data");
    std::memcpy(values.data(), binary().data() + offset, bytes);
    return values;
  }

  GlbChunks chunks_;
  std::vector<Track> tracks_;
  float duration_ = 0;
};

}  // namespace isoextract::test
