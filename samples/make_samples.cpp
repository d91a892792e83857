// Writes the sample volumes beside this file: make_samples FOLDER. Writes the same bytes in every run.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <zlib.h>

#include "field/demo_field.hpp"

namespace isoextract {
namespace {

// The samples of a demo field; i varies fastest.
struct Demo {
  explicit Demo(const std::string& spec) : field(field::make_demo_field(spec, Context())) {
    if (!field) throw std::runtime_error(field.error().message);
    const auto& dense = std::get<field::DenseSamples>(field->samples);
    values = {static_cast<const float*>(dense.data), dense.count()};
    dims = dense.dims;
  }

  Result<field::ScalarField> field;
  std::span<const float> values;
  glm::ivec3 dims;
};

void append_gzip(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  const gzFile file = gzopen(path.c_str(), "ab9");
  const bool written = file != nullptr && gzwrite(file, bytes.data(), static_cast<unsigned>(bytes.size())) > 0;
  if (gzclose(file) != Z_OK || !written) throw std::runtime_error("cannot write " + path.string());
}

// Writes 8-bit samples, as a scanner does: 128 + 80 times the gyroid's value, which is within +-1.5.
void write_gyroid(const std::filesystem::path& path) {
  const Demo demo("demo:gyroid?size=49");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(demo.values.size());
  for (const float value : demo.values) bytes.push_back(static_cast<std::uint8_t>(std::lround(128 + 80 * value)));

  const auto& linear = demo.field->index_to_world.linear;
  const auto& offset = demo.field->index_to_world.offset;
  const std::string header = fmt::format(
      "NRRD0004\n# gyroid, four periods, stored = 128 + 80 * value; made by isoextract's samples/make_samples.cpp\n"
      "type: uint8\ndimension: 3\nspace dimension: 3\nsizes: {} {} {}\n"
      "space directions: ({},0,0) (0,{},0) (0,0,{})\nspace origin: ({},{},{})\nencoding: gzip\n\n",
      demo.dims.x, demo.dims.y, demo.dims.z, linear[0].x, linear[1].y, linear[2].z, offset.x, offset.y, offset.z);
  std::ofstream(path, std::ios::binary) << header;
  append_gzip(path, bytes);
}

// OpenVDB writes a random UUID into every file. A fixed one makes the file the same in every run.
void fix_unique_name(const std::filesystem::path& path) {
  constexpr std::streamoff kOffset = 8 + 3 * 4 + 1;  // after magic number, three version numbers and a flag
  constexpr std::string_view kName = "00000000-0000-4000-8000-000000000000";
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  std::array<char, kName.size()> found{};
  file.seekg(kOffset).read(found.data(), found.size());
  for (const std::size_t dash : {8U, 13U, 18U, 23U}) {
    if (found.at(dash) != '-') throw std::runtime_error("no unique name where OpenVDB's file format has it");
  }
  file.seekp(kOffset).write(kName.data(), kName.size());
  if (!file.flush()) throw std::runtime_error("cannot write " + path.string());
}

// Writes a fog volume: density 0.5 on the surface of the balls, 1 inside, falling to the background value 0 outside.
void write_metaballs(const std::filesystem::path& path) {
  const Demo demo("demo:metaballs?size=48");
  auto grid = openvdb::FloatGrid::create(0.0F);
  auto accessor = grid->getAccessor();
  std::size_t n = 0;
  for (int k = 0; k < demo.dims.z; ++k) {
    for (int j = 0; j < demo.dims.y; ++j) {
      for (int i = 0; i < demo.dims.x; ++i) {
        const float density = std::clamp(0.5F + demo.values[n++], 0.0F, 1.0F);
        if (density > 0) accessor.setValue({i, j, k}, density);
      }
    }
  }
  grid->pruneGrid();
  grid->setName("density");
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setSaveFloatAsHalf(true);
  const auto& place = demo.field->index_to_world;
  auto transform = openvdb::math::Transform::createLinearTransform(place.linear[0].x);
  transform->postTranslate({place.offset.x, place.offset.y, place.offset.z});
  grid->setTransform(transform);

  openvdb::io::File file(path.string());
  file.setCompression(openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  file.write({grid});
  file.close();
  fix_unique_name(path);
}

}  // namespace
}  // namespace isoextract

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_samples FOLDER\n", stderr);
    return 1;
  }
  try {
    openvdb::initialize();
    const std::filesystem::path folder = argv[1];
    isoextract::write_gyroid(folder / "gyroid.nrrd");
    isoextract::write_metaballs(folder / "metaballs.vdb");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "make_samples: %s\n", e.what());
    return 1;
  }
  return 0;
}
