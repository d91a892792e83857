#include <algorithm>
#include <cmath>
#include <filesystem>

#include "hdf5_parts.hpp"

namespace isoextract_hdf5 {
namespace {

// Returns whether a type is IEEE half float, whose bits the host converts itself.
bool is_half(hid_t type) {
  std::size_t sign = 0;
  std::size_t exponent = 0;
  std::size_t exponent_bits = 0;
  std::size_t mantissa = 0;
  std::size_t mantissa_bits = 0;
  return H5Tget_size(type) == 2 && H5Tget_ebias(type) == 15 && H5Tget_norm(type) == H5T_NORM_IMPLIED &&
         H5Tget_fields(type, &sign, &exponent, &exponent_bits, &mantissa, &mantissa_bits) >= 0 && sign == 15 &&
         exponent == 10 && exponent_bits == 5 && mantissa == 0 && mantissa_bits == 10;
}

std::int32_t integer_type(hid_t type) {
  const bool is_signed = H5Tget_sign(type) != H5T_SGN_NONE;
  switch (H5Tget_size(type)) {
    case 1: return is_signed ? ISOEXTRACT_I8 : ISOEXTRACT_U8;
    case 2: return is_signed ? ISOEXTRACT_I16 : ISOEXTRACT_U16;
    case 4: return is_signed ? ISOEXTRACT_I32 : ISOEXTRACT_U32;
    case 3:
    case 5:
    case 6:
    case 7:
    case 8: return ISOEXTRACT_F64;
    default: return ISOEXTRACT_NOT_SCALAR;  // the library overruns its buffers with damaged types that are larger
  }
}

std::int32_t float_type(hid_t type) {
  if (is_half(type)) return ISOEXTRACT_F16;
  const std::size_t size = H5Tget_size(type);
  return size <= 4 ? ISOEXTRACT_F32 : size <= 16 ? ISOEXTRACT_F64 : ISOEXTRACT_NOT_SCALAR;
}

void describe_type(hid_t type, Grid& grid) {
  const std::size_t bits = 8 * H5Tget_size(type);
  switch (H5Tget_class(type)) {
    case H5T_INTEGER:
    case H5T_ENUM: {
      const bool is_enum = H5Tget_class(type) == H5T_ENUM;
      const Handle base = is_enum ? Handle(H5Tget_super(type), "HDF5 cannot read a type")
                                  : Handle(H5Tcopy(type), "HDF5 cannot read a type");
      grid.sample_type = integer_type(base);
      grid.type_name = (H5Tget_sign(base) == H5T_SGN_NONE ? "uint" : "int") + std::to_string(bits);
      if (is_enum) grid.type_name = "enumeration of " + grid.type_name;
      return;
    }
    case H5T_FLOAT:
      grid.sample_type = float_type(type);
      grid.type_name = "float" + std::to_string(bits);
      return;
    case H5T_COMPOUND: grid.type_name = "compound"; return;
    case H5T_STRING: grid.type_name = "string"; return;
    case H5T_BITFIELD: grid.type_name = "bit field"; return;
    case H5T_ARRAY: grid.type_name = "array"; return;
    case H5T_REFERENCE: grid.type_name = "reference"; return;
    case H5T_VLEN: grid.type_name = "sequence"; return;
    default: grid.type_name = "opaque"; return;
  }
}

Handle memory_type(std::int32_t type) {
  const char* const what = "HDF5 cannot make a type";
  switch (type) {
    case ISOEXTRACT_U8: return {H5Tcopy(H5T_NATIVE_UINT8), what};
    case ISOEXTRACT_I8: return {H5Tcopy(H5T_NATIVE_INT8), what};
    case ISOEXTRACT_U16: return {H5Tcopy(H5T_NATIVE_UINT16), what};
    case ISOEXTRACT_I16: return {H5Tcopy(H5T_NATIVE_INT16), what};
    case ISOEXTRACT_U32: return {H5Tcopy(H5T_NATIVE_UINT32), what};
    case ISOEXTRACT_I32: return {H5Tcopy(H5T_NATIVE_INT32), what};
    case ISOEXTRACT_F32: return {H5Tcopy(H5T_NATIVE_FLOAT), what};
    case ISOEXTRACT_F64: return {H5Tcopy(H5T_NATIVE_DOUBLE), what};
    default: break;
  }
  Handle half(H5Tcopy(H5T_IEEE_F32LE), what);
  check(H5Tset_fields(half, 15, 10, 5, 0, 10), what);
  check(H5Tset_precision(half, 16), what);
  check(H5Tset_size(half, 2), what);
  check(H5Tset_ebias(half, 15), what);
  return half;
}

void check_filters(hid_t properties) {
  const int count = H5Pget_nfilters(properties);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0;
    std::size_t values = 0;
    unsigned config = 0;
    std::array<char, 64> name{};
    const H5Z_filter_t filter = H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &values, nullptr,
                                               name.size() - 1, name.data(), &config);
    if (filter < 0 || H5Zfilter_avail(filter) > 0) continue;
    throw ReadError("expected chunks compressed by a filter of HDF5 itself, such as gzip, found the filter '" +
                    std::string(name.data()) + "' (number " + std::to_string(filter) + ")");
  }
}

// The layout of a dataset's samples in the file.
struct Layout {
  std::vector<hsize_t> chunk;  // empty if samples are contiguous
  std::uint64_t chunk_bytes = 0;
};

Layout read_layout(hid_t dataset, std::size_t rank) {
  const Handle properties(H5Dget_create_plist(dataset), "HDF5 cannot read a dataset's layout");
  check_filters(properties);
  if (H5Pget_external_count(properties) > 0)
    throw ReadError("expected samples in the file itself, found a dataset whose samples are in raw files");
  if (H5Dget_storage_size(dataset) == 0 && H5Pget_layout(properties) != H5D_VIRTUAL)
    throw ReadError("its dataset has no samples: no program wrote them");
  Layout layout;
  if (H5Pget_layout(properties) != H5D_CHUNKED) return layout;
  layout.chunk.resize(rank);
  if (H5Pget_chunk(properties, static_cast<int>(rank), layout.chunk.data()) != static_cast<int>(rank))
    throw ReadError("HDF5 cannot read a dataset's chunks");
  const Handle type(H5Dget_type(dataset), "HDF5 cannot read a dataset's type");
  layout.chunk_bytes = H5Tget_size(type);
  for (const hsize_t length : layout.chunk) {
    if (length == 0 || __builtin_mul_overflow(layout.chunk_bytes, length, &layout.chunk_bytes))
      throw ReadError("expected chunks of less than 2^64 bytes");
  }
  return layout;
}

// A selection as the start and count of a hyperslab.
struct Slab {
  std::vector<hsize_t> start;
  std::vector<hsize_t> count;
};

class BoxReader {
 public:
  BoxReader(hid_t dataset, const Source& source, const isoextract_volume_selection& selection, Layout layout)
      : dataset_(dataset),
        space_(H5Dget_space(dataset), "HDF5 cannot read a dataset's size"),
        source_(source),
        selection_(selection),
        layout_(std::move(layout)) {
    const std::size_t rank = source.shape.size();
    if (H5Sget_simple_extent_ndims(space_) != static_cast<int>(rank))
      throw ReadError("expected datasets of one size for all volumes, found another number of dimensions");
    slab_.start.assign(rank, 0);
    slab_.count.assign(rank, 1);
    for (std::size_t i = 0; i < 3; ++i) {
      slab_.start[source.axis[i]] = selection.first[i];
      slab_.count[source.axis[i]] = selection.count[i];
    }
    if (!source.volume_index.empty()) {
      slab_.start[source.volumes.at(0)] = source.volume_index.at(selection.volume);
      return;
    }
    std::uint64_t volume = selection.volume;
    for (std::size_t i = source.volumes.size(); i-- > 0;) {
      const std::size_t dimension = source.volumes[i];
      slab_.start[dimension] = volume % source.shape[dimension];
      volume /= source.shape[dimension];
    }
  }

  // The number of layers along the grid's z axis from `z` to the end of its chunks.
  [[nodiscard]] std::uint64_t layers_from(std::uint64_t z) const {
    const std::uint64_t end = selection_.first[2] + selection_.count[2];
    const std::uint64_t thickness = layout_.chunk.empty() ? 1 : layout_.chunk[source_.axis[2]];
    return std::min(end, (z / thickness + 1) * thickness) - z;
  }

  void read_layers(std::uint64_t z, std::uint64_t layers, std::int64_t component, hid_t type, void* to) {
    slab_.start[source_.axis[2]] = z;
    slab_.count[source_.axis[2]] = layers;
    if (source_.component) slab_.start[*source_.component] = static_cast<hsize_t>(component);
    check(H5Sselect_hyperslab(space_, H5S_SELECT_SET, slab_.start.data(), nullptr, slab_.count.data(), nullptr),
          "HDF5 cannot select its samples");
    if (H5Sselect_valid(space_) <= 0) throw ReadError("expected more samples in its dataset");
    const hsize_t samples = layers * selection_.count[0] * selection_.count[1];
    const Handle memory(H5Screate_simple(1, &samples, nullptr), "HDF5 cannot select its samples");
    check(H5Dread(dataset_, type, memory, space_, H5P_DEFAULT, to), "HDF5 cannot read its samples");
  }

  void count_chunks(ReadFacts& facts) const {
    if (layout_.chunk.empty()) return;
    facts.parts_read = 1;
    facts.parts = 1;
    for (std::size_t i = 0; i < source_.shape.size(); ++i)
      facts.parts *= (source_.shape[i] + layout_.chunk[i] - 1) / layout_.chunk[i];
    for (std::size_t i = 0; i < 3; ++i) {
      const hsize_t size = layout_.chunk[source_.axis[i]];
      const std::uint64_t first = selection_.first[i];
      facts.parts_read *= (first + selection_.count[i] - 1) / size - first / size + 1;
    }
    const bool reads_all = selection_.component == ISOEXTRACT_COMPONENT_LENGTH;
    if (source_.component && reads_all) {
      const hsize_t size = layout_.chunk[*source_.component];
      facts.parts_read *= (source_.shape[*source_.component] + size - 1) / size;
    }
  }

 private:
  hid_t dataset_;
  Handle space_;
  const Source& source_;
  const isoextract_volume_selection& selection_;
  Layout layout_;
  Slab slab_;
};

// Computes the lengths of vectors; reads one component at a time.
template <class T>
void read_lengths(BoxReader& reader, std::uint64_t z, std::uint64_t layers, const Grid& grid, std::uint64_t samples,
                  const isoextract_plugin_host& host, T* to) {
  HostMemory memory(host);
  memory.take(2 * samples * sizeof(double));
  std::vector<double> sum(samples);
  std::vector<double> values(samples);
  const Handle type = memory_type(ISOEXTRACT_F64);
  for (std::uint64_t component = 0; component < grid.components; ++component) {
    reader.read_layers(z, layers, static_cast<std::int64_t>(component), type, values.data());
    for (std::size_t i = 0; i < samples; ++i) sum[i] += values[i] * values[i];
  }
  for (std::size_t i = 0; i < samples; ++i) to[i] = static_cast<T>(std::sqrt(sum[i]));
}

}  // namespace

std::vector<hsize_t> describe_dataset(hid_t dataset, Grid& grid) {
  const Handle type(H5Dget_type(dataset), "HDF5 cannot read a dataset's type");
  const Handle space(H5Dget_space(dataset), "HDF5 cannot read a dataset's size");
  describe_type(type, grid);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank <= 0) return {};
  std::vector<hsize_t> shape(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  return shape;
}

std::vector<std::string> other_files(hid_t dataset, const std::string& path) {
  std::vector<std::string> files;
  const Handle properties(H5Dget_create_plist(dataset), "HDF5 cannot read a dataset's layout");
  if (H5Pget_layout(properties) != H5D_VIRTUAL) return files;
  std::size_t count = 0;
  check(H5Pget_virtual_count(properties, &count), "HDF5 cannot read a virtual dataset");
  for (std::size_t i = 0; i < count; ++i) {
    std::array<char, 4096> name{};
    if (H5Pget_virtual_filename(properties, i, name.data(), name.size()) < 0) continue;
    const std::string wanted = name.data();
    if (wanted == "." || wanted.find('%') != std::string::npos) continue;
    files.push_back((std::filesystem::path(path).parent_path() / wanted).string());
  }
  std::ranges::sort(files);
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

ReadFacts read_source(hid_t file, const std::string& path, const Source& source, const Grid& grid,
                      const isoextract_volume_selection& selection, const isoextract_plugin_host& host) {
  const std::string& name = source.paths.size() == 1 ? source.paths[0] : source.paths.at(selection.volume);
  if (object_type(file, name) != H5O_TYPE_DATASET) throw ReadError("its dataset " + name + " is missing");
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), "HDF5 cannot open its dataset " + name);
  for (const std::string& other : other_files(dataset, path)) {
    if (!std::filesystem::exists(other)) throw ReadError("a file of its virtual dataset is missing: " + other);
  }
  Layout layout = read_layout(dataset, source.shape.size());
  HostMemory chunk_memory(host);
  chunk_memory.take(layout.chunk_bytes);
  BoxReader reader(dataset, source, selection, std::move(layout));
  const Handle type = memory_type(grid.sample_type);
  const std::int32_t result = selected_type(grid, selection);
  const std::uint64_t layer = selection.count[0] * selection.count[1];
  auto* to = static_cast<char*>(selection.box);
  const std::uint64_t end = selection.first[2] + selection.count[2];
  for (std::uint64_t z = selection.first[2]; z < end;) {
    isoextract_plugin::check_cancelled(host);
    const std::uint64_t layers = reader.layers_from(z);
    const std::uint64_t samples = layers * layer;
    if (selection.component != ISOEXTRACT_COMPONENT_LENGTH) {
      reader.read_layers(z, layers, selection.component, type, to);
    } else if (result == ISOEXTRACT_F64) {
      read_lengths(reader, z, layers, grid, samples, host, static_cast<double*>(static_cast<void*>(to)));
    } else {
      read_lengths(reader, z, layers, grid, samples, host, static_cast<float*>(static_cast<void*>(to)));
    }
    to += samples * isoextract_plugin::sample_size(result);
    z += layers;
  }
  ReadFacts facts;
  facts.note = source.note;
  if (grid.type_name == "int64" || grid.type_name == "uint64")
    facts.note +=
        std::string(facts.note.empty() ? "" : "; ") + "the reader makes doubles of 64-bit integers, exact up to 2^53";
  reader.count_chunks(facts);
  return facts;
}

}  // namespace isoextract_hdf5
