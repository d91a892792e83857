// Writes small, valid files of each format for the fuzz targets to start from: fuzz_seeds FOLDER makes FOLDER/FORMAT/*.
// What a format offers (encodings, byte orders, transforms, compressions) appears at least once.
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

#include "fuzz/zarr_seeds.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/particle_io/particle_files.hpp"
#include "unit/volume_io/npz_files.hpp"
#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"

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
  // Around the lengths and numbers that teem has room for.
  const std::string many(1100, 'x');
  seed("long_texts", fmt::format("# {0}\nkey:={0}\ncontent: {0}\ntype: uint8\nencoding: raw\n", many),
       ramp_bytes<std::uint8_t>());
  seed("long_field", fmt::format("kinds: {}\ntype: uint8\nencoding: raw\n", many), "");
  seed("long_name", fmt::format("{}: 1\ntype: uint8\nencoding: raw\n", many), "");
  seed("longest_field", fmt::format("space: {}\ntype: uint8\nencoding: raw\n", many.substr(0, 760)), "");
  const std::string twice = ramp_bytes<std::uint8_t>() + ramp_bytes<std::uint8_t>();
  write_bytes(folder / "series",
              "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 3 4 5 2\n"
              "kinds: domain domain domain time\nencoding: raw\n\n" +
                  twice);
  write_bytes(folder / "lanes",
              "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 2 3 4 5\n"
              "kinds: list domain domain domain\nencoding: gzip\n\n" +
                  gzip(twice));
  std::string ones = "1";
  for (int i = 0; i < 16; ++i) ones += " 1";
  write_bytes(folder / "many_values", fmt::format("NRRD0005\ndimension: 16\nsizes: {}\n\n", ones));
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

  one.dim[0] = 4;
  one.dim[4] = 2;
  const std::string twice = ramp_bytes<std::uint8_t>() + ramp_bytes<std::uint8_t>();
  write_bytes(folder / "series", bytes_of(one, 352, twice));
  write_bytes(folder / "series_gzip", gzip(bytes_of(one, 352, twice)));
  one.dim[0] = 3;

  one.datatype = NIFTI_TYPE_INT16;
  one.bitpix = 16;
  one.sform_code = 0;
  one.qform_code = NIFTI_XFORM_ALIGNED_ANAT;
  one.quatern_b = 0.5F;
  one.pixdim[0] = -1;
  write_bytes(folder / "one_qform", bytes_of(one, 352, ramp_bytes<std::int16_t>()));
  one.datatype = NIFTI_TYPE_RGB24;
  write_bytes(folder / "colors", bytes_of(one, 352, std::string(180, 'x')));
  one.datatype = NIFTI_TYPE_INT64;
  write_bytes(folder / "wide", bytes_of(one, 352, std::string(480, '\0')));
  one.datatype = NIFTI_TYPE_INT16;
  one.dim[0] = 5;
  one.dim[4] = 1;
  one.dim[5] = 2;
  write_bytes(folder / "vectors", bytes_of(one, 352, ramp_bytes<std::int16_t>() + ramp_bytes<std::int16_t>()));

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
  seed("series", 1, "<f4", "False", "(2, 5, 4, 3)", ramp_bytes<float>() + ramp_bytes<float>());
  seed("lanes", 1, ">i2", "True", "(2, 5, 4, 3)", ramp_bytes<std::int16_t>() + ramp_bytes<std::int16_t>());
  seed("bool", 1, "|b1", "False", "(2, 2, 2)", std::string("\0\1\1\0\0\0\1\1", 8));
  seed("i64", 1, ">i8", "False", "(2, 2, 2)", std::string(64, '\0'));
  seed("u64", 1, "<u8", "False", "(2, 2, 2)", std::string(64, '\1'));
  seed("complex", 1, "<c8", "False", "(2, 2, 2)", std::string(64, '\1'));
  seed("vectors", 1, "<i2", "False", "(5, 4, 3, 2)", ramp_bytes<std::int16_t>() + ramp_bytes<std::int16_t>());
}

void write_npz(const fs::path& folder) {
  const std::string array = npy_array("<f4", "(5, 4, 3)", ramp_bytes<float>());
  const std::string vectors = npy_array("<i2", "(5, 4, 3, 2)", ramp_bytes<std::int16_t>() + ramp_bytes<std::int16_t>());
  write_bytes(folder / "stored", zip_bytes({zip_part("a.npy", array, false)}));
  write_bytes(folder / "packed", zip_bytes({zip_part("a.npy", array, true)}, "a comment"));
  write_bytes(folder / "several", zip_bytes({zip_part("a.npy", array, true), zip_part("b.txt", "text", false),
                                             zip_part("v.npy", vectors, true)}));
  ZipPart large = zip_part("a.npy", array, true);
  large.zip64 = true;
  write_bytes(folder / "zip64", zip_bytes({large}));
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
  write_bytes(folder / "time", "metaballs?size=8&time=0.25");
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
  const auto flags = openvdb::BoolGrid::create();
  flags->fill({{0, 0, 0}, {1, 1, 1}}, true);
  const auto places = openvdb::MaskGrid::create();
  places->fill({{0, 0, 0}, {2, 2, 2}}, true);
  const auto instance = openvdb::FloatGrid::create(fog->treePtr());
  instance->setSaveFloatAsHalf(true);
  velocity->fill({{0, 0, 0}, {1, 2, 3}}, openvdb::Vec3s(1, 2, 3));
  write_vdb_stream(folder / "stream", {fog, instance});
  write_vdb_stream(folder / "stream_several", {velocity, flags, places, counts}, openvdb::io::COMPRESS_ZIP);
  write_vdb_stream(folder / "stream_blosc", {precise, fog}, openvdb::io::COMPRESS_BLOSC, false);
}

// A folder for each target; see fuzz_particles.cpp for the first byte.
void write_particles(const fs::path& root) {
  const auto seed = [&](const std::string& name, const std::string& target, const std::string& bytes) {
    const fs::path folder = root / ("particles_" + target);
    fs::create_directories(folder);
    for (const char bits : {'\1', '\x0e', '\x12'}) {
      write_bytes(folder / fmt::format("{}_{}", name, static_cast<int>(bits)), std::string(1, bits) + bytes);
    }
  };
  seed("ply_little", "ply", ply_header("binary_little_endian") + ply_body(std::endian::little));
  seed("ply_text", "ply", ply_header("ascii") + "1 2 3 200 0 0.5 0.25\n4 5 6 201 -3 0.5 3\n7 8 9.5 202 -6 0.5 6\n");
  seed("ply_lists", "ply",
       "ply\nformat binary_big_endian 1.0\nelement cell 1\nproperty list uchar int ids\nelement vertex 1\n"
       "property float x\nproperty list ushort float near\nproperty float y\nproperty float z\nend_header\n" +
           std::string("\1abcd"
                       "1234"
                       "\0\1abcd"
                       "12345678",
                       24));
  seed("bgeo_old", "bgeo", bgeo_classic());
  seed("bgeo_gzip", "bgeo", gzip(bgeo_classic()));
  seed("bgeo_new", "houdini", houdini_geometry());
  seed("bgeo_big", "houdini", houdini_geometry(std::endian::big));
  seed("npy_rows", "npy", npy_bytes("'>f4'", "(2, 4)", std::string(32, '\1')));
  seed("npy_columns", "npy", npy_bytes("'<i8'", "(2, 3)", std::string(48, '\1'), true));
  seed("npy_fields", "npy",
       npy_bytes("[('id', '<i2'), ('tag', '|S4'), ('pos', '<f8', (3,))]", "(2,)", std::string(60, '\1')));
  seed("npy_texts", "npy", npy_bytes("[('x', '|S4'), ('y', '<U1'), ('z', '|V2')]", "(2,)", std::string(20, 'a')));
  seed("npy_dates", "npy",
       npy_bytes("[('x', '<f4'), ('y', '<f4'), ('z', '<f4'), ('t', '<M8[ns]'), ('c', '<c8'), ('f', '<f16')]", "(1,)",
                 std::string(44, '\1')));
  seed("xyz", "xyz", "3\nwater\nO 1 2 3 0.5\nH 4 5 6 1\nH 7 8 9.5 2\n1\n\n1 2 3\n");
  seed("xyz_extended", "xyz", std::string(kExtendedXyz));
  seed("lammps", "lammps", std::string(kLammpsDump));
  seed("lammps_tilted", "lammps",
       "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS xy xz yz pp pp pp\n8 15 1\n20 25.5 -2\n"
       "30 36 0.5\nITEM: ATOMS xs ys zs id\n0.5 0.25 0.75 1\n");
  seed("gro", "gro", std::string(kGromacs));
  seed("pdb", "pdb", std::string(kProteinDataBank));
  seed("csv", "csv", "\xEF\xBB\xBFid;x [mm];y [mm];z [mm];\"a \"\"b\"\r\n1;2;3;4;\"q\"\r\n2;;1e400;nan;-1\r\n");
  seed("csv_words", "csv", "# x y z\n1 2 3\n4 5 6\n");
}

void write_selections(const fs::path& folder) {
  constexpr std::array<std::string_view, 14> kConditions{"type == 2 && z > 10",
                                                         "|v| <= 10 && !(v.x > 10) and v[1] in {0}",
                                                         "species in {O, 'C a'}",
                                                         "element != Si",
                                                         "T == 0.1 or x < 25",
                                                         "type in {1, 4..6}",
                                                         "type in 1..3",
                                                         "not type == 1",
                                                         "abs(-T) * 2 + sqrt(x) / 3 >= 1e-3",
                                                         "min(T, v[2]) < max(x, y - z)",
                                                         "`odd name`[1] == 1",
                                                         "length(v) > 0.5 || length(T) < 1",
                                                         "((((type))) == 1)",
                                                         "x < y == z"};
  for (std::size_t i = 0; i < kConditions.size(); ++i) {
    write_bytes(folder / fmt::format("condition{}", i), std::string(kConditions[i]));
  }
}

mesh::Mesh colored(mesh::ComponentType type, std::size_t components) {
  mesh::Mesh mesh = tetrahedron("colored", {1e7, 0.25, -3});
  add_color(mesh, type, components);
  add_attribute(mesh, "heat", mesh::ComponentType::f32, 1);
  add_attribute(mesh, "way", mesh::ComponentType::i16, 3, true);
  return mesh;
}

// Once as each of the product's writers writes it.
void write_written(const fs::path& folder, mesh_io::MeshFormat format) {
  const mesh_io::MeshFormatInfo& info = mesh_io::mesh_format_info(format);
  const auto seed = [&](const std::string& name, const mesh::Mesh& mesh, bool flat = false) {
    for (const bool ascii : {false, true}) {
      if (ascii && !info.has_text_option) continue;
      const auto path = folder / (ascii ? name + "_text" : name);
      const auto written = mesh_io::write_meshes({&mesh, 1}, path, {format, flat, ascii}, Context());
      if (!written) throw std::runtime_error(written.error().message);
    }
  };
  seed("plain", tetrahedron());
  seed("normals", sphere(2, true));
  seed("flat", tetrahedron(), true);
  if (!info.has_attributes) return;
  seed("color_u8", colored(mesh::ComponentType::u8, 4));
  seed("color_f32", colored(mesh::ComponentType::f32, 3));
}

void write_plys(const fs::path& folder) {
  write_written(folder, mesh_io::MeshFormat::ply);
  std::string body;
  for (const float coordinate : {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}) body += pack(coordinate, std::endian::big);
  body += std::string("\4\0\0\0\1\0\2\0\3", 9) + std::string("\1\0\2", 3);
  write_bytes(folder / "big_endian",
              "ply\nformat binary_big_endian 1.0\ncomment seed\nelement vertex 4\nproperty float x\nproperty float y\n"
              "property float z\nelement face 1\nproperty list uchar short vertex_index\nelement edge 1\n"
              "property list uchar ushort ends\nend_header\n" +
                  body);
  write_bytes(folder / "old_lines",
              "ply\rformat ascii 1.0\relement vertex 3\rproperty float x\rproperty float y\rproperty float z\r"
              "element face 1\rproperty list uchar int vertex_index\rend_header\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r");
}

void write_objs(const fs::path& folder) {
  write_written(folder, mesh_io::MeshFormat::obj);
  write_bytes(folder / "polygons",
              "# seed\no a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1e-3 .5\nvt 0 1\nf 1/1 2/1 3/1 4/1\nf -1 -2 -3\nl 1 2\n");
  write_bytes(folder / "old_lines", "\xEF\xBB\xBF# seed\rv 0 0 0\rv 1 0 0\r\nv 1 1 0\rf 1 2 3\r");
  write_bytes(folder / "joined_lines", "v 0 0 \\\n0\nv 1 \\\r\n0 \\\n 0\nv 1 1 0\nf 1 \\\n2 3\\\n\n");
  std::string polygon = "v 0 0 0\nv 1 0 0\nv 1 1 0\nf";
  for (int i = 0; i < 20; ++i) polygon += fmt::format(" {}", i % 3 + 1);
  write_bytes(folder / "many_corners", polygon + "\n");
}

// In every way of packing that the format has.
void write_packed(const fs::path& folder, mesh_io::MeshFormat format) {
  const auto seed = [&](const std::string& name, const mesh::Mesh& mesh, const mesh_io::MeshPacking& packing,
                        bool flat = false) {
    const auto written = mesh_io::write_meshes({&mesh, 1}, folder / name, {format, flat, false, packing}, Context());
    if (!written) throw std::runtime_error(written.error().message);
  };
  mesh::Mesh attributes = sphere(2, true);
  add_color(attributes, mesh::ComponentType::u8, 3);
  add_attribute(attributes, "heat", mesh::ComponentType::f32, 1);
  // Three sheets at one edge, which Draco packs triangle by triangle.
  const mesh::Mesh sheets =
      make_mesh("sheets", {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  mesh_io::MeshPacking packing;
  packing.compression = mesh_io::Compression::draco;
  seed("draco", attributes, packing);
  seed("draco_flat", sphere(2, false), packing, true);
  seed("draco_sheets", sheets, packing);
  if (format == mesh_io::MeshFormat::drc) return;
  packing.compression = mesh_io::Compression::meshopt;
  seed("meshopt", attributes, packing);
  packing.quantize = true;
  seed("meshopt_quantized", attributes, packing);
  packing.compression = mesh_io::Compression::none;
  seed("quantized", attributes, packing);
}

void write_stls(const fs::path& folder) {
  write_written(folder, mesh_io::MeshFormat::stl);
  write_bytes(folder / "capitals",
              "SOLID A\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nVERTEX -0 1 0\nVERTEX 1E0 0 0\nENDLOOP\n"
              "ENDFACET\nENDSOLID A\n");
  write_bytes(folder / "longer", read_bytes(folder / "plain") + "more");
}

void write_glbs(const fs::path& folder) {
  write_written(folder, mesh_io::MeshFormat::glb);
  write_packed(folder, mesh_io::MeshFormat::glb);
}

void write_drcs(const fs::path& folder) { write_packed(folder, mesh_io::MeshFormat::drc); }

// Of one primitive; `buffer` is what its values are read from, in base64.
std::string one_primitive(std::string_view more, std::string_view accessors, std::string_view views, std::size_t bytes,
                          std::string_view buffer) {
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},{}"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"scale":[2,2,4]}}],"meshes":[)"
      R"({{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"accessors":[{}],"bufferViews":[{}],"buffers":[)"
      R"({{"byteLength":{},"uri":"data:;base64,{}"}}]}})",
      more, accessors, views, bytes, buffer);
}

// The data of the first ones lie in a file that the target has beside its input, those of the others in their text.
void write_gltfs(const fs::path& folder) {
  const TempFolder pairs;
  write_written(pairs.path(), mesh_io::MeshFormat::gltf);
  for (const std::string& name : pairs.names()) {
    if (name.ends_with(".bin")) continue;
    std::string text = read_bytes(pairs / name);
    const std::string data = name + ".bin";
    for (std::size_t at = text.find(data); at != std::string::npos; at = text.find(data, at + 1)) {
      text.replace(at, data.size(), "beside.bin");
    }
    write_bytes(folder / name, text);
  }
  // Zeros but for one corner at (1, 0, 0), its index in front of it.
  write_bytes(folder / "sparse",
              one_primitive("",
                            R"({"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":)"
                            R"({"bufferView":0,"componentType":5125},"values":{"bufferView":1}}})",
                            R"({"buffer":0,"byteLength":4},{"buffer":0,"byteOffset":4,"byteLength":12})", 16,
                            "AQAAAAAAgD8AAAAAAAAAAA=="));
  // Three corners of bytes, each with one of padding.
  write_bytes(folder / "quantised",
              one_primitive(R"("extensionsRequired":["KHR_mesh_quantization","KHR_materials_unlit"],)",
                            R"({"bufferView":0,"componentType":5120,"normalized":true,"count":3,"type":"VEC3"})",
                            R"({"buffer":0,"byteLength":12,"byteStride":4})", 12, "AAAAAH8AgAAAfwAA"));
  write_bytes(folder / "embedded",
              R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"children": [1],
"matrix": [1,0,0,0, 0,-1,0,0, 0,0,1,0, 4,5,6,1]}, {"mesh": 0, "rotation": [0,0,1,0], "scale": [1,2,3],
"translation": [1,0,0]}], "meshes": [{"primitives": [{"mode": 5, "attributes": {"POSITION": 0, "_HEAT": 1}},
{"mode": 6, "indices": 1, "attributes": {"POSITION": 0, "_HEAT": 1}}, {"mode": 0, "attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}, {"bufferView": 1,
"byteOffset": 1, "componentType": 5121, "count": 4, "type": "SCALAR"}], "bufferViews": [{"buffer": 0,
"byteLength": 48}, {"buffer": 0, "byteOffset": 44, "byteLength": 16, "byteStride": 4}], "buffers": [{"byteLength": 60,
"uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAQACAAMAAAAA"
}]})");
}

void write_seeds(const fs::path& folder) {
  const std::array<std::pair<const char*, void (*)(const fs::path&)>, 15> formats{{{"vdb", write_vdbs},
                                                                                   {"nrrd", write_nrrd},
                                                                                   {"nifti", write_nifti},
                                                                                   {"npy", write_npy},
                                                                                   {"npz", write_npz},
                                                                                   {"raw", write_raw},
                                                                                   {"demo", write_demo},
                                                                                   {"selection", write_selections},
                                                                                   {"ply", write_plys},
                                                                                   {"obj", write_objs},
                                                                                   {"stl", write_stls},
                                                                                   {"glb", write_glbs},
                                                                                   {"gltf", write_gltfs},
                                                                                   {"drc", write_drcs},
                                                                                   {"zarr", write_zarr_seeds}}};
  for (const auto& [name, write] : formats) {
    fs::create_directories(folder / name);
    write(folder / name);
  }
  write_particles(folder);
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
