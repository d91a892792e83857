// A plug-in for the tests: volumes as text. A file is "textvolume", then for each grid "NAME NX NY NZ" and as many
// numbers. A file without a grid is an error; a grid named "hollow" is given without samples, "short" with too few.
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
    for (int i = 0; i < 3; ++i) text.grid.index_to_world[5 * i] = 0.5;
    text.grid.index_to_world[3] = 10;
    volume->grids.push_back(text.grid);
  }
  return volume;
}

int probe(const unsigned char* start, size_t bytes, const char* /*path*/) {
  return bytes >= 10 && std::string(start, start + 10) == "textvolume" ? 1 : 0;
}

int list(const char* path, isoextract_volume_list* list) {
  auto volume = read_text(path);
  if (!volume) return 1;
  *list = {volume->grids.data(), volume->grids.size(), volume.get()};
  static_cast<void>(volume.release());
  return 0;
}

void free_list(isoextract_volume_list* list) { delete static_cast<TextVolume*>(list->owner); }

int open(const char* path, size_t grid, const isoextract_plugin_host* /*host*/, isoextract_volume_samples* samples) {
  auto volume = read_text(path);
  if (!volume) return 1;
  const TextGrid& text = volume->texts[grid];
  *samples = {text.name == "hollow" ? nullptr : text.values.data(),
              (text.values.size() - (text.name == "short" ? 1 : 0)) * sizeof(float), nullptr, nullptr, volume.get()};
  static_cast<void>(volume.release());
  return 0;
}

void free_samples(isoextract_volume_samples* samples) { delete static_cast<TextVolume*>(samples->owner); }

const char* error_text() { return problem.c_str(); }

constexpr isoextract_volume_plugin_v3 kPlugin{TEXT_VOLUME_VERSION, TEXT_VOLUME_ID, "text",       probe,     list,
                                              free_list,           open,           free_samples, error_text};

}  // namespace

const isoextract_volume_plugin_v3* isoextract_volume_plugin() { return &kPlugin; }
