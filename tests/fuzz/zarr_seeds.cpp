// Seeds of the Zarr plug-in: hierarchies of both versions whose chunks are 4 x 4 x 4 bytes, with each codec.
#include "fuzz/zarr_seeds.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "fuzz/zarr_entries.hpp"
#include "support/temp_folder.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

std::string entry(std::string_view key, const std::string& value) {
  const auto found = std::ranges::find(fuzz::kZarrKeys, key);
  std::string bytes(1, static_cast<char>(found - fuzz::kZarrKeys.begin()));
  bytes += static_cast<char>(value.size() & 0xff);
  bytes += static_cast<char>(value.size() >> 8);
  return bytes + value;
}

std::string little_endian(std::uint64_t value, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
  return text;
}

std::string v3_array(std::string_view codecs, std::string_view more = "") {
  return fmt::format(
      R"({{"zarr_format":3,"node_type":"array","shape":[4,4,7],"data_type":"uint8","fill_value":1,)"
      R"("chunk_grid":{{"name":"regular","configuration":{{"chunk_shape":[4,4,4]}}}},)"
      R"("chunk_key_encoding":{{"name":"default","configuration":{{"separator":"/"}}}},"codecs":[{}]{}}})",
      codecs, more);
}

std::string v2_array(std::string_view compressor, std::string_view filters = "null") {
  return fmt::format(R"({{"zarr_format":2,"shape":[4,4,7],"chunks":[4,4,4],"dtype":"|u1","compressor":{},"filters":{},)"
                     R"("order":"F","fill_value":0}})",
                     compressor, filters);
}

constexpr std::string_view kBytes = R"({"name":"bytes"})";

}  // namespace

void write_zarr_seeds(const std::filesystem::path& folder) {
  std::string chunk;
  for (char i = 0; i < 64; ++i) chunk += static_cast<char>(i * 3);
  const auto seed = [&](const std::string& name, const std::string& bytes) { write_bytes(folder / name, bytes); };
  seed("v3", entry("zarr.json", v3_array(kBytes)) + entry("c/0/0/0", chunk));
  seed("v3_gzip",
       entry("zarr.json", v3_array(fmt::format(R"({},{{"name":"gzip"}})", kBytes))) + entry("c/0/0/0", gzip(chunk)));
  // A frame of one raw block; a blosc chunk that is copied; an LZ4 block of literals.
  const std::string zstd = "\x28\xB5\x2F\xFD\x20\x40" + little_endian(64 << 3 | 1, 3) + chunk;
  seed("v3_zstd",
       entry("zarr.json", v3_array(fmt::format(R"({},{{"name":"zstd"}})", kBytes))) + entry("c/0/0/0", zstd));
  seed("v3_crc32c", entry("zarr.json", v3_array(fmt::format(R"({},{{"name":"crc32c"}})", kBytes))) +
                        entry("c/0/0/0", chunk + little_endian(0, 4)));
  const std::string blosc =
      little_endian(0x01020102, 4) + little_endian(64, 4) + little_endian(64, 4) + little_endian(80, 4) + chunk;
  seed("v2_blosc", entry(".zarray", v2_array(R"({"id":"blosc"})")) + entry("0.0.0", blosc));
  const std::string lz4 = little_endian(64, 4) + "\xF0" + little_endian(64 - 15, 1) + chunk;
  seed("v2_lz4", entry(".zarray", v2_array(R"({"id":"lz4"})", R"([{"id":"delta","dtype":"|u1"},{"id":"shuffle"}])")) +
                     entry("0.0.0", lz4) + entry(".zattrs", R"({"_ARRAY_DIMENSIONS":["z","y","x"]})"));
  seed("v2_none", entry(".zarray", v2_array("null")) + entry("0.0.0", chunk) + entry("0.0.1", chunk));
  const std::string sharding =
      R"({"name":"sharding_indexed","configuration":{"chunk_shape":[2,4,4],"codecs":[{"name":"bytes"}],)"
      R"("index_codecs":[{"name":"bytes","configuration":{"endian":"little"}}],"index_location":"end"}})";
  const std::string index = little_endian(0, 8) + little_endian(32, 8) + std::string(16, '\xFF');
  seed("v3_shards", entry("zarr.json", v3_array(sharding)) + entry("c/0/0/0", chunk + index) +
                        entry("c/0/0/1", chunk + little_endian(32, 8) + little_endian(32, 8) + index.substr(0, 16)));
  const std::string transpose = R"({"name":"transpose","configuration":{"order":[2,0,1]}},{"name":"bytes"})";
  const std::string image =
      R"({"zarr_format":3,"node_type":"group","attributes":{"ome":{"version":"0.5","multiscales":[{"axes":[)"
      R"({"name":"z","type":"space","unit":"nanometer"},{"name":"y","type":"space","unit":"micrometer"},)"
      R"({"name":"x","type":"space"}],"datasets":[{"path":"0","coordinateTransformations":[)"
      R"({"type":"scale","scale":[1,2,3]},{"type":"translation","translation":[0,1,2]}]},{"path":"1"}]}],)"
      R"("omero":{"channels":[{"label":"a"}]},"image-label":{"colors":[{"label-value":1,"rgba":[255,0,0,255]}],)"
      R"("properties":[{"label-value":1,"name":"a"}]}}}})";
  seed("ome", entry("zarr.json", image) + entry("0/zarr.json", v3_array(transpose)) + entry("0/c/0/0/0", chunk) +
                  entry("1/zarr.json", v3_array(kBytes)) + entry("labels/a/zarr.json", image) +
                  entry("labels/zarr.json", R"({"zarr_format":3,"node_type":"group"})"));
  seed("xarray",
       entry("zarr.json", R"({"zarr_format":3,"node_type":"group","consolidated_metadata":{"metadata":{}}})") +
           entry("0/zarr.json", v3_array(kBytes, R"(,"dimension_names":["time","y","x"])")) +
           entry("x/zarr.json",
                 R"({"zarr_format":3,"node_type":"array","shape":[7],"data_type":"float32","fill_value":"NaN",)"
                 R"("chunk_grid":{"name":"regular","configuration":{"chunk_shape":[7]}},"codecs":[],)"
                 R"("chunk_key_encoding":{"name":"default"}})") +
           entry("x/c/0", std::string(28, '\x3F')));
}

}  // namespace isoextract::test
