// A plug-in for the tests: volumes as text. A file is "textvolume", then for each grid "NAME NX NY NZ" and as many
// numbers. A file without a grid is an error; of a grid named "short" the plug-in fills too little.
#include <cstdint>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <volume_plugin.h>

namespace {

thread_local std::string problem;

struct TextGrid {
  std::string name;
  isoextract_volume_grid grid{};
  std::vector<float> values;
};

struct TextVolume {
  std::vector<TextGrid> texts;
  std::vector<isoextract_volume_grid> grids;
};

std::unique_ptr<TextVolume> read_text(const char* path) {
  std::ifstream file(path);
  auto volume = std::make_unique<TextVolume>();
  std::string word;
  file >> word;
  for (TextGrid text; file >> text.name >> text.grid.dims[0] >> text.grid.dims[1] >> text.grid.dims[2];) {
    text.values.resize(text.grid.dims[0] * text.grid.dims[1] * text.grid.dims[2]);
    for (float& value : text.values) file >> value;
    volume->texts.push_back(text);
  }
  if (volume->texts.empty()) {
    problem = "expected a grid, found none";
    return nullptr;
  }
  for (TextGrid& text : volume->texts) {
    text.grid.name = text.name.c_str();
    text.grid.type_name = "float";
    text.grid.world_space = "lab";
    text.grid.sample_type = ISOEXTRACT_F32;
    text.grid.kind = ISOEXTRACT_LEVEL_SET;
    text.grid.has_placement = 1;
    text.grid.slope = 1;
    text.grid.components = 1;
    text.grid.volumes = 1;
    for (int i = 0; i < 3; ++i) text.grid.index_to_world[5 * i] = 0.5;
    text.grid.index_to_world[3] = 10;
    volume->grids.push_back(text.grid);
  }
  return volume;
}

int probe(const unsigned char* start, size_t bytes, const char* /*path*/) {
  return bytes >= 10 && std::string(start, start + 10) == "textvolume" ? 1 : 0;
}

int list(const isoextract_volume_request* request, const isoextract_plugin_host* /*host*/,
         isoextract_volume_list* list) {
  auto volume = read_text(request->path);
  if (!volume) return ISOEXTRACT_READ_FAILED;
  *list = {};
  list->grids = volume->grids.data();
  list->count = volume->grids.size();
  list->owner = volume.release();
  return 0;
}

void free_list(isoextract_volume_list* list) { delete static_cast<TextVolume*>(list->owner); }

int open(const isoextract_volume_list* list, const isoextract_volume_selection* selection,
         const isoextract_plugin_host* /*host*/, isoextract_volume_samples* samples) {
  const TextGrid& text = static_cast<const TextVolume*>(list->owner)->texts[selection->grid];
  auto* to = static_cast<float*>(selection->box);
  for (std::uint64_t z = 0; z < selection->count[2]; ++z) {
    for (std::uint64_t y = 0; y < selection->count[1]; ++y) {
      for (std::uint64_t x = 0; x < selection->count[0]; ++x) {
        const std::uint64_t row = selection->first[1] + y + text.grid.dims[1] * (selection->first[2] + z);
        *to++ = text.values[selection->first[0] + x + text.grid.dims[0] * row];
      }
    }
  }
  const std::uint64_t count = selection->count[0] * selection->count[1] * selection->count[2];
  *samples = {
      (count - (text.name == "short" ? 1 : 0)) * sizeof(float), nullptr, count, text.values.size(), nullptr, nullptr};
  return 0;
}

void free_samples(isoextract_volume_samples* /*samples*/) {}

const char* error_text() { return problem.c_str(); }

constexpr isoextract_volume_plugin_v4 kPlugin{TEXT_VOLUME_VERSION, TEXT_VOLUME_ID, "text",       probe,     list,
                                              free_list,           open,           free_samples, error_text};

}  // namespace

const isoextract_volume_plugin_v4* isoextract_volume_plugin() { return &kPlugin; }
