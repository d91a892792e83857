#include "convert/conversion_job.hpp"

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <tuple>
#include <type_traits>
#include <variant>

#include <fmt/format.h>

#include "convert/json_values.hpp"
#include "files/content_hash.hpp"

namespace isoextract::convert {
namespace {

constexpr std::array kRawNames{"dims", "dtype", "endian", "skip", "components", "planar"};

template <class T>
concept Structure = std::same_as<T, volume_io::RawLayout> || requires {
  T::kMembers;
};

template <Structure T>
constexpr auto names_of() {
  if constexpr (std::same_as<T, volume_io::RawLayout>) {
    return kRawNames;
  } else {
    return T::kMembers;
  }
}

// Returns references to all members of a structure. Does not compile if names_of() has another number of names.
template <Structure T>
auto members_of(const T& value) {
  constexpr std::size_t kCount = names_of<T>().size();
  if constexpr (kCount == 1) {
    const auto& [a] = value;
    return std::tie(a);
  } else if constexpr (kCount == 2) {
    const auto& [a, b] = value;
    return std::tie(a, b);
  } else if constexpr (kCount == 3) {
    const auto& [a, b, c] = value;
    return std::tie(a, b, c);
  } else if constexpr (kCount == 4) {
    const auto& [a, b, c, d] = value;
    return std::tie(a, b, c, d);
  } else if constexpr (kCount == 5) {
    const auto& [a, b, c, d, e] = value;
    return std::tie(a, b, c, d, e);
  } else if constexpr (kCount == 6) {
    const auto& [a, b, c, d, e, f] = value;
    return std::tie(a, b, c, d, e, f);
  } else if constexpr (kCount == 7) {
    const auto& [a, b, c, d, e, f, g] = value;
    return std::tie(a, b, c, d, e, f, g);
  } else if constexpr (kCount == 9) {
    const auto& [a, b, c, d, e, f, g, h, i] = value;
    return std::tie(a, b, c, d, e, f, g, h, i);
  } else if constexpr (kCount == 10) {
    const auto& [a, b, c, d, e, f, g, h, i, j] = value;
    return std::tie(a, b, c, d, e, f, g, h, i, j);
  } else {
    static_assert(kCount == 15);
    const auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = value;
    return std::tie(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o);
  }
}

// Overloads in a class, so that they find each other in any order.
struct JobJson {
  template <class E>
  requires std::is_enum_v<E>
  static Json of(E value) { return word_of(value); }

  template <class T>
  requires std::is_arithmetic_v<T>
  static Json of(T value) { return value; }

  static Json of(const std::string& text) { return text; }
  static Json of(std::endian value) { return value == std::endian::big ? "big" : "little"; }
  static Json of(const glm::ivec3& v) { return {v.x, v.y, v.z}; }
  static Json of(const glm::dvec3& v) { return json_of(v); }
  static Json of(const std::array<std::string, 3>& texts) { return texts; }
  static Json of(const std::array<double, 2>& range) { return range; }
  static Json of(const std::array<bool, 3>& flags) { return flags; }
  static Json of(const field::Box& box) { return json_of(box); }
  static Json of(const IsoChoice& choice) { return json_of(choice); }

  // Returns a number, "cuda:N" or a name; null means any device.
  static Json of(const gl::DeviceChoice& device) {
    if (const auto* index = std::get_if<int>(&device)) return *index;
    if (const auto* cuda = std::get_if<gl::CudaIndex>(&device)) return fmt::format("cuda:{}", cuda->number);
    if (const auto* name = std::get_if<gl::DeviceName>(&device)) return name->part;
    return nullptr;
  }

  // Returns a number, or "length".
  static Json of(const volume_io::ComponentChoice& choice) {
    return choice.number ? Json(*choice.number) : Json("length");
  }

  static Json of(const PictureFileOptions& picture) {
    Json json = Json::object();
    json["width"] = picture.width;
    json["height"] = picture.height;
    json["azimuth"] = picture.angles.azimuth;
    json["elevation"] = picture.angles.elevation;
    json["distance"] = of(picture.angles.distance);
    json["look_at"] = of(picture.angles.look_at);
    json["field_of_view"] = picture.fovy * 180 / std::numbers::pi;
    const glm::dvec4& color = picture.background;
    json["background_color"] = Json{color.r, color.g, color.b, color.a};
    return json;
  }

  template <class T>
  static Json of(const std::optional<T>& value) {
    return value ? of(*value) : Json(nullptr);
  }

  template <class T>
  static Json of(const std::vector<T>& values) {
    Json array = Json::array();
    for (const T& value : values) array.push_back(of(value));
    return array;
  }

  template <Structure T>
  static Json of(const T& value) {
    Json json = Json::object();
    add_members(json, value);
    return json;
  }

  template <Structure T>
  static void add_members(Json& json, const T& value) {
    std::apply(
        [&](const auto&... members) {
          std::size_t at = 0;
          ((json[names_of<T>()[at++]] = of(members)), ...);
        },
        members_of(value));
  }

  static Json of_job(const ConversionJob& job);
};

Json JobJson::of_job(const ConversionJob& job) {
  Json json = Json::object();
  const auto add = [&](const char* name, const auto& member) { json[name] = of(member); };
  add("input", job.source.input);
  add("mesh_input", job.source.mesh);
  add("masks", job.source.masks);
  add("input_format", job.source.read.format);
  add("grid", job.source.read.grid);
  add("more_grids", job.source.more_grids);
  add("volume", job.source.read.volume);
  add("component", job.source.read.component);
  add("raw", job.source.read.raw);
  add("level", job.source.read.level);
  add("resample", job.source.read.resamples);
  add("axis_order", job.source.read.axis_order);
  add("no_data", job.source.read.no_data);
  add("spacing", job.source.read.spacing);
  add("origin", job.source.read.origin);
  add("inside", job.source.read.kind);
  add("away_from_zero", job.source.away_from_zero);
  add("particles", job.source.particles);
  add("attributes", job.source.attributes);
  add("filters", job.source.filters);
  add("blurs", job.source.blurs);
  add("resolution", job.source.resolution);
  add("voxel_size", job.source.voxel_size);
  add("kernel", job.source.kernel);
  add("roi", job.source.roi);
  add("roi_snap", job.source.roi_snap);
  add("clip", job.source.clip);
  add("space", job.source.placement.space);
  add("up", job.source.placement.up);
  add("turned_to_y_up", job.source.placement.turn_z_up_to_y_up);
  add("turned_to_z_up", job.source.placement.turn_y_up_to_z_up);
  add("scale", job.source.placement.scale);
  add("unit", job.source.placement.unit);
  add("to_unit", job.source.placement.to_unit);
  add("to_space", job.source.placement.to_space);
  add("center", job.source.placement.center);
  add("method", job.surface.method);
  add("nan", job.surface.nan);
  add("cap", job.surface.cap);
  add("voxel_faces", job.surface.voxel_faces);
  add("relaxations", job.surface.relaxations);
  add("background", job.surface.background);
  add("labels_min_voxels", job.surface.least_voxels);
  add("heights", job.surface.heights);
  add("normals", job.normals);
  add("color", job.color);
  add("label_names", job.label_names);
  add("opacity", job.opacity);
  add_members(json, job.edits);
  add("error", job.error);
  add("verify", job.verify);
  add("backend", job.backend.backend);
  add("device", job.backend.gpu.device);
  add("gpu_memory", job.backend.gpu.memory_bytes);
  add("empty", job.empty);
  // Every kind of file has its keys; kinds that the job does not write have the defaults or null.
  const MeshFileOptions meshes = job.meshes();
  add("format", meshes.format);
  add("ascii", meshes.ascii);
  add("compression", meshes.packing.compression);
  add("quantize", meshes.packing.quantize);
  add("position_bits", meshes.packing.position_bits);
  add("optimize_order", meshes.packing.optimize_order);
  const auto add_if_written = [&](const char* name, const auto* file) {
    json[name] = file != nullptr ? of(*file) : Json(nullptr);
  };
  add_if_written("field_file", job.writes<FieldFileOptions>());
  add_if_written("picture_file", job.writes<PictureFileOptions>());
  add_if_written("particle_file", job.writes<ParticleFileOptions>());
  add("outputs", job.outputs);
  return json;
}

}  // namespace

std::vector<IsoChoice> ConversionJob::isos() const {
  std::vector<IsoChoice> all;
  for (const OutputFileJob& output : outputs) all.insert(all.end(), output.isos.begin(), output.isos.end());
  return all;
}

MeshFileOptions ConversionJob::meshes() const {
  const auto* meshes = writes<MeshFileOptions>();
  return meshes != nullptr ? *meshes : MeshFileOptions();
}

Json json_of(const ConversionJob& job) { return JobJson::of_job(job); }

std::string hash_of(const ConversionJob& job) {
  // Hashes CBOR, not text: JSON text cannot hold paths that are not UTF-8.
  const std::vector<std::uint8_t> bytes = Json::to_cbor(json_of(job));
  return files::content_hash({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace isoextract::convert
