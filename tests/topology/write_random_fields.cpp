// Writes random fields, their true topology and that of our meshes, for scripts/compare_topology.py.
//
//   write_random_fields COUNT FOLDER
//
// Writes two files for every kind of field. FOLDER/KIND.f32 has COUNT fields of 5^3 floats, x fastest. FOLDER/KIND.json
// is an array with the Euler numbers of the components of three surfaces: of the field just above iso 0, just below it,
// and our mesh.
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <vector>

#include <tbb/parallel_for.h>
#include <nlohmann/json.hpp>

#include "extract/extractor.hpp"
#include "support/mesh_components.hpp"
#include "support/random_trilinear.hpp"

namespace isoextract {
namespace {

nlohmann::json json_of(const std::optional<test::SurfaceTopology>& topology) {
  return topology ? nlohmann::json(*topology) : nlohmann::json();
}

void write_kind(test::RandomKind kind, std::uint32_t count, const std::filesystem::path& folder) {
  std::vector<std::vector<float>> fields(count);
  std::vector<nlohmann::json> facts(count);
  tbb::parallel_for(0U, count, [&](std::uint32_t seed) {
    fields[seed] = test::random_trilinear(kind, seed);
    const auto mesh =
        extract::make_cpu_extractor()->extract(test::as_field(fields[seed]), extract::ExtractOptions{}, Context());
    facts[seed] = {{"above", json_of(test::true_topology(kind, fields[seed], test::Side::above))},
                   {"below", json_of(test::true_topology(kind, fields[seed], test::Side::below))},
                   {"isoextract", mesh ? nlohmann::json(test::component_euler_numbers(mesh->mesh)) : nlohmann::json()}};
  });
  std::string name(test::kind_name(kind));
  std::replace(name.begin(), name.end(), ' ', '_');
  std::ofstream samples(folder / (name + ".f32"), std::ios::binary);
  for (const std::vector<float>& field : fields) {
    samples.write(reinterpret_cast<const char*>(field.data()),
                  static_cast<std::streamsize>(field.size() * sizeof(float)));
  }
  std::ofstream(folder / (name + ".json")) << nlohmann::json(facts);
}

}  // namespace
}  // namespace isoextract

int main(int argc, char** argv) {
  std::uint32_t count = 0;
  if (argc != 3 || std::from_chars(argv[1], argv[1] + std::strlen(argv[1]), count).ec != std::errc{}) {
    std::cerr << "usage: write_random_fields COUNT FOLDER\n";
    return 1;
  }
  for (const auto kind : isoextract::test::kRandomKinds) isoextract::write_kind(kind, count, argv[2]);
}
