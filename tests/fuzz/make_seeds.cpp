// Writes small, valid files of each volume format for the fuzz targets to start from: fuzz_seeds FOLDER makes
// FOLDER/FORMAT/*. What a format offers (encodings, byte orders, transforms, compressions) appears at least once.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nifti1.h>
#include <nifti2.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include "support/temp_folder.hpp"
#include "unit/volumes/vdb_files.hpp"
#include "unit/volumes/volume_files.hpp"

namespace isoextract::test {
namespace {

namespace fs = std::filesystem;

void write_nrrd(const fs::path& folder) {
  constexpr std::string_view kHead = "NRRD0005\n# seed\ndimension: 3\nsizes: 3 4 5\n";
  const auto seed = [&](const std::string& name, std::string_view fields, const std::string& data) {
    write_bytes(folder / name, fmt::format("{}{}\n{}", kHead, fields, data));
  };
  seed("u8", "type: unsigned char\nencoding: raw\n", ramp_bytes<std::uint8_t>());
  seed("gzip", "type: uint8\nencoding: gzip\n", gzip(ramp_bytes<std::uint8_t>()));
  seed("i16_big", "type: short\nendian: big\nencoding: raw\nspacings: 1 2 3\n",
       ramp_bytes<std::int16_t>(std::endian::big));
  seed("f32_oblique",
       "type: float\nendian: little\nspace: left-posterior-superior\nspace directions: (0,1,0) (-1,0,0) (0,0,2.5)\n"
       "space origin: (10,-20,1e3)\nkinds: domain domain domain\ncontent: seed\nkey:=value\nencoding: raw\n",
       ramp_bytes<float>());
  seed("f64", "type: double\nendian: little\nspacings: 1 1 1\naxis mins: 0 1 2\nencoding: raw\n", ramp_bytes<double>());
  seed("text", "type: float\nencoding: ascii\n", "1 2 3 4.5 nan\n");
  seed("detached", "type: uint8\nencoding: raw\ndata file: volume.nrrd\nbyte skip: -1\n", ramp_bytes<std::uint8_t>());
  seed("list", "type: uint8\nencoding: raw\ndata file: slice%02d.raw 1 3 1 2\n", "");
}

template <class Header>
std::string bytes_of(const Header& header, std::size_t until_data, const std::string& data) {
  std::string bytes(until_data, '\0');
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes + data;
}

void write_nifti(const fs::path& folder) {
  nifti_1_header one{};
  one.sizeof_hdr = sizeof one;
  std::copy_n("n+1", 4, one.magic);
  one.vox_offset = 352;
  const std::array<short, 4> dims{3, 3, 4, 5};
  std::copy(dims.begin(), dims.end(), one.dim);
  std::fill(one.pixdim, one.pixdim + 4, 1.0F);
  one.datatype = NIFTI_TYPE_UINT8;
  one.bitpix = 8;
  one.scl_slope = 2;
  one.sform_code = NIFTI_XFORM_SCANNER_ANAT;
  one.srow_x[0] = -1;
  one.srow_y[1] = one.srow_z[2] = 2;
  write_bytes(folder / "one", bytes_of(one, 352, ramp_bytes<std::uint8_t>()));
  write_bytes(folder / "one_gzip", gzip(bytes_of(one, 352, ramp_bytes<std::uint8_t>())));

  one.datatype = NIFTI_TYPE_INT16;
  one.bitpix = 16;
  one.sform_code = 0;
  one.qform_code = NIFTI_XFORM_ALIGNED_ANAT;
  one.quatern_b = 0.5F;
  one.pixdim[0] = -1;
  write_bytes(folder / "one_qform", bytes_of(one, 352, ramp_bytes<std::int16_t>()));

  nifti_2_header two{};
  two.sizeof_hdr = sizeof two;
  std::memcpy(two.magic, "n+2\0\r\n\032\n", 8);
  two.vox_offset = 544;
  std::copy(dims.begin(), dims.end(), two.dim);
  std::fill(two.pixdim, two.pixdim + 4, 1.0);
  two.datatype = NIFTI_TYPE_FLOAT32;
  two.bitpix = 32;
  write_bytes(folder / "two", bytes_of(two, 544, ramp_bytes<float>()));
}

void write_npy(const fs::path& folder) {
  const auto seed = [&](const std::string& name, char version, std::string_view descr, std::string_view order,
                        std::string_view shape, const std::string& data) {
    std::string dict = fmt::format("{{'descr': '{}', 'fortran_order': {}, 'shape': {}, }}\n", descr, order, shape);
    std::string head = std::string("\x93NUMPY") + version + '\0' + static_cast<char>(dict.size()) + '\0';
    if (version > 1) head += std::string(2, '\0');
    write_bytes(folder / name, head + dict + data);
  };
  seed("u8", 1, "|u1", "False", "(5, 4, 3)", ramp_bytes<std::uint8_t>());
  seed("f32", 1, "<f4", "False", "(5, 4, 3)", ramp_bytes<float>());
  seed("f16_fortran", 2, "<f2", "True", "(3, 4, 5)", ramp_bytes<field::Half>());
  seed("i16_big", 3, ">i2", "False", "(12, 5)", ramp_bytes<std::int16_t>(std::endian::big));
  seed("f64", 1, "<f8", "False", "(5, 4, 3)", ramp_bytes<double>());
}

void write_raw(const fs::path& folder) {
  for (int type = 0; type < 9; ++type) {
    const auto endian = type % 2 == 0 ? std::endian::little : std::endian::big;
    std::string head(16, '\0');
    for (int axis = 0; axis < 3; ++axis) put(head, static_cast<std::size_t>(4 * axis), kDims[axis]);
    put(head, 12, static_cast<std::uint8_t>(type));
    put(head, 13, static_cast<std::uint8_t>(type % 2));
    put(head, 14, static_cast<std::uint8_t>(3));
    const std::string samples = visit_sample_type(
        static_cast<field::SampleType>(type), [&](auto t) { return ramp_bytes<typename decltype(t)::type>(endian); });
    write_bytes(folder / fmt::format("type{}", type), head + "..." + samples);
  }
}

void write_demo(const fs::path& folder) {
  write_bytes(folder / "size", "sphere?size=8");
  write_bytes(folder / "plain", "marschner-lobb?size=2&size=3");
}

// All near the origin's corner of one 4096^3 node: each further one would add its masks and values.
void write_vdbs(const fs::path& folder) {
  openvdb::initialize();
  const auto sphere = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(2, {8, 4, 4}, 1, 1.5F);
  sphere->setName("surface");
  write_vdb(folder / "level_set", {sphere});
  write_vdb(folder / "level_set_zip", {sphere}, openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK);
  write_vdb(folder / "level_set_blosc", {sphere}, openvdb::io::COMPRESS_BLOSC);

  const auto fog = openvdb::FloatGrid::create();
  fog->setName("density");
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  fog->setSaveFloatAsHalf(true);
  fog->fill({{1, 2, 3}, {4, 5, 9}}, 1);
  fog->tree().addTile(1, {16, 0, 0}, 0.5F, true);
  openvdb::Mat4R sheared = openvdb::Mat4R::identity();
  sheared(0, 1) = 0.25;
  fog->setTransform(openvdb::math::Transform::createLinearTransform(sheared));
  const auto counts = openvdb::Int32Grid::create(7);
  counts->setName("density");
  counts->fill({{0, 0, 0}, {1, 1, 1}}, -3);
  const auto precise = openvdb::DoubleGrid::create(-1);
  precise->fill({{0, 0, 0}, {2, 1, 1}}, 0.5);
  const auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  write_vdb(folder / "half", {fog});
  write_vdb(folder / "several", {fog, counts, precise, velocity});
}

void write_seeds(const fs::path& folder) {
  const std::array<std::pair<const char*, void (*)(const fs::path&)>, 6> formats{{{"vdb", write_vdbs},
                                                                                  {"nrrd", write_nrrd},
                                                                                  {"nifti", write_nifti},
                                                                                  {"npy", write_npy},
                                                                                  {"raw", write_raw},
                                                                                  {"demo", write_demo}}};
  for (const auto& [name, write] : formats) {
    fs::create_directories(folder / name);
    write(folder / name);
  }
}

}  // namespace
}  // namespace isoextract::test

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: fuzz_seeds FOLDER\n", stderr);
    return 1;
  }
  try {
    isoextract::test::write_seeds(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fuzz_seeds: %s\n", error.what());
    return 1;
  }
  return 0;
}
