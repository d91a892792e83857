// Jobs as JSON and back. Every type has an encode() and a decode(), members of one class so that they find each other
// whatever their order; decode() leaves its target alone and says what was expected where the JSON holds something
// else.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <glm/glm.hpp>

#include "base/words.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::convert {

template <class E>
concept EnumWithWords = std::is_enum_v<E> && requires {
  words_of(E{});
};

// What JSON has values for.
template <class T>
concept JsonValue = std::same_as<T, bool> || std::same_as<T, double> || std::same_as<T, std::uint64_t> ||
    std::same_as<T, std::int64_t> || std::same_as<T, std::string>;

template <class T>
concept JobStructure =
    std::same_as<T, volume_io::RawLayout> || std::same_as<T, ParticleOptions> || std::same_as<T, AttributeChoice> ||
    std::same_as<T, ColourChoice> || std::same_as<T, LabelTableFile> || std::same_as<T, SimplifyBound> ||
    std::same_as<T, TriangleCount> || std::same_as<T, SimplifyChoice> || std::same_as<T, OutputFileJob> ||
    std::same_as<T, FilterStep> || std::same_as<T, ClipPlane> || std::same_as<T, FieldFileOptions> ||
    std::same_as<T, BlurStep> || std::same_as<T, LeastPiece> || std::same_as<T, PieceChoice> ||
    std::same_as<T, SmoothChoice> || std::same_as<T, PictureFileOptions> || std::same_as<T, ConversionJob>;

class JobJson {
 public:
  using Expected = std::string;  // empty if the value was taken; else what it should have been

  template <EnumWithWords E>
  static Json encode(E value) {
    return word_of(value);
  }
  template <EnumWithWords E>
  static Expected decode(const Json& json, E& target) {
    const auto found = json.is_string() ? value_of<E>(json.get<std::string>()) : std::nullopt;
    if (found) {
      target = *found;
      return {};
    }
    std::string words;
    for (const Word<E>& entry : words_of(E{})) words += (words.empty() ? "one of " : ", ") + std::string(entry.word);
    return words;
  }

  template <JsonValue T>
  static Json encode(const T& value) {
    return value;
  }
  static Expected decode(const Json& json, bool& target) {
    return take(json, &Json::is_boolean, "true or false", target);
  }
  static Expected decode(const Json& json, double& target) { return take(json, &Json::is_number, "a number", target); }
  static Expected decode(const Json& json, std::uint64_t& target) {
    return take(json, &Json::is_number_unsigned, "a whole number from 0 on", target);
  }
  static Expected decode(const Json& json, std::int64_t& target) {
    const bool fits =
        json.is_number_unsigned() ? std::in_range<std::int64_t>(json.get<std::uint64_t>()) : json.is_number_integer();
    if (!fits) return "a whole number";
    target = json.get<std::int64_t>();
    return {};
  }
  static Expected decode(const Json& json, std::string& target) {
    return take(json, &Json::is_string, "a text", target);
  }

  static Json encode(std::endian value) { return value == std::endian::big ? "big" : "little"; }
  static Expected decode(const Json& json, std::endian& target) {
    if (json != "big" && json != "little") return "one of little, big";
    target = json == "big" ? std::endian::big : std::endian::little;
    return {};
  }

  static Json encode(const glm::ivec3& v) { return {v.x, v.y, v.z}; }
  static Expected decode(const Json& json, glm::ivec3& target) {
    bool fits = json.is_array() && json.size() == 3;
    for (std::size_t axis = 0; fits && axis < 3; ++axis) {
      fits = json[axis].is_number_integer() && std::in_range<int>(json[axis].get<std::int64_t>());
    }
    if (!fits) return "three whole numbers";
    target = {json[0].get<int>(), json[1].get<int>(), json[2].get<int>()};
    return {};
  }

  static Json encode(const glm::dvec3& v) { return json_of(v); }
  static Expected decode(const Json& json, glm::dvec3& target) {
    bool fits = json.is_array() && json.size() == 3;
    for (std::size_t axis = 0; fits && axis < 3; ++axis) fits = json[axis].is_number();
    if (!fits) return "three numbers";
    target = {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
    return {};
  }

  static Json encode(const std::array<std::string, 3>& texts) { return texts; }
  static Expected decode(const Json& json, std::array<std::string, 3>& target) {
    const auto is_text = [](const Json& value) { return value.is_string(); };
    if (!json.is_array() || json.size() != 3 || !std::all_of(json.begin(), json.end(), is_text)) return "three texts";
    target = json.get<std::array<std::string, 3>>();
    return {};
  }

  static Json encode(const std::array<double, 2>& range) { return range; }
  static Expected decode(const Json& json, std::array<double, 2>& target) {
    if (!json.is_array() || json.size() != 2 || !json[0].is_number() || !json[1].is_number()) return "two numbers";
    target = json.get<std::array<double, 2>>();
    return {};
  }

  static Json encode(const field::Box& box) { return json_of(box); }
  static Expected decode(const Json& json, field::Box& target) {
    field::Box read;
    const bool fits = json.is_object() && json.size() == 2 && json.contains("min") && json.contains("max") &&
                      decode(json["min"], read.min).empty() && decode(json["max"], read.max).empty();
    if (!fits) return "an object of min and max, three numbers each";
    target = read;
    return {};
  }

  static Json encode(const IsoChoice& choice) { return json_of(choice); }
  static Expected decode(const Json& json, IsoChoice& target) {
    const std::string word = json.is_string() ? json.get<std::string>() : "";
    auto choice = iso_choice_of(word);
    if (!choice) choice = label_choice_of(word);
    if (!json.is_number() && !choice) return "a number, auto, a percentile such as p99 or a label such as label 5";
    target = choice ? *choice : IsoChoice(json.get<double>());
    return {};
  }

  // A number, "cuda:N" or a name; null is whichever there is.
  static Json encode(const gl::DeviceChoice& device) {
    if (const auto* index = std::get_if<int>(&device)) return *index;
    if (const auto* cuda = std::get_if<gl::CudaIndex>(&device)) return fmt::format("cuda:{}", cuda->number);
    if (const auto* name = std::get_if<gl::DeviceName>(&device)) return name->part;
    return nullptr;
  }
  static Expected decode(const Json& json, gl::DeviceChoice& target) {
    if (json.is_null()) {
      target = {};
      return {};
    }
    const std::string text = json.is_number_unsigned() ? json.dump() : json.is_string() ? json.get<std::string>() : "";
    auto choice = gl::parse_device_choice(text);
    if (!choice) return "the number of a device, cuda:N, a name or null";
    target = std::move(*choice);
    return {};
  }

  // A number, or "length".
  static Json encode(const volume_io::ComponentChoice& choice) {
    return choice.number ? Json(*choice.number) : Json("length");
  }
  static Expected decode(const Json& json, volume_io::ComponentChoice& target) {
    if (json == "length") {
      target.number.reset();
      return {};
    }
    std::int64_t number = 0;
    if (!decode(json, number).empty()) return "the number of a component or length";
    target.number = number;
    return {};
  }

  template <class T>
  static Json encode(const std::optional<T>& value) {
    return value ? encode(*value) : Json(nullptr);
  }
  template <class T>
  static Expected decode(const Json& json, std::optional<T>& target) {
    if (json.is_null()) {
      target.reset();
      return {};
    }
    T read{};
    if (const Expected expected = decode(json, read); !expected.empty()) return expected + ", or null";
    target = std::move(read);
    return {};
  }

  template <class T>
  static Json encode(const std::vector<T>& values) {
    Json array = Json::array();
    for (const T& value : values) array.push_back(encode(value));
    return array;
  }
  template <class T>
  static Expected decode(const Json& json, std::vector<T>& target) {
    if (!json.is_array()) return "a list";
    std::vector<T> read(json.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      if (const Expected expected = decode(json[i], read[i]); !expected.empty()) return "a list, each " + expected;
    }
    target = std::move(read);
    return {};
  }

  template <JobStructure T>
  static Json encode(const T& value) {
    Json json = Json::object();
    visit(value, [&](const char* name, const auto& member) { json[name] = encode(member); });
    return json;
  }
  template <JobStructure T>
  static Expected decode(const Json& json, T& target) {
    if (!json.is_object()) return "an object";
    T read = target;
    Expected problem;
    std::set<std::string> known;
    visit(read, [&](const char* name, auto& member) {
      known.insert(name);
      if (!problem.empty() || !json.contains(name)) return;
      const Expected expected = decode(json[name], member);
      if (!expected.empty()) problem = fmt::format("'{}' to be {}", name, expected);
    });
    for (const auto& [name, value] : json.items()) {
      if (problem.empty() && !known.contains(name)) problem = fmt::format("no member '{}'", name);
    }
    if (problem.empty()) target = std::move(read);
    return problem;
  }

 private:
  template <JsonValue T>
  static Expected take(const Json& json, bool (Json::*is_one)() const, const char* expected, T& target) {
    if (!(json.*is_one)()) return expected;
    target = json.get<T>();
    return {};
  }

  // The members of a structure by name. One list serves both ways, so neither can leave a member out.
  template <class T, class Visitor>
  static void visit(T& value, Visitor&& each) {
    using Structure = std::remove_const_t<T>;
    if constexpr (std::same_as<Structure, volume_io::RawLayout>) {
      each("dims", value.dims);
      each("dtype", value.type);
      each("endian", value.endian);
      each("skip", value.skip);
    } else if constexpr (std::same_as<Structure, ParticleOptions>) {
      each("expected", value.expected);
      each("method", value.method);
      each("radius", value.radius);
      each("cell_size", value.cell_size);
      each("smoothing_length", value.smoothing_length);
      each("weight", value.weight);
      each("deposit", value.deposit);
      each("not_finite", value.bad);
      each("columns", value.columns);
    } else if constexpr (std::same_as<Structure, AttributeChoice>) {
      each("name", value.name);
      each("from", value.from);
      each("written", value.written);
      each("optional", value.optional);
      each("kind", value.kind);
      each("spacing", value.spacing);
      each("origin", value.origin);
      each("no_data", value.no_data);
      each("volume", value.volume);
      each("component", value.component);
    } else if constexpr (std::same_as<Structure, ColourChoice>) {
      each("attribute", value.attribute);
      each("map", value.map);
      each("range", value.range);
    } else if constexpr (std::same_as<Structure, LabelTableFile>) {
      each("path", value.path);
      each("hash", value.hash);
    } else if constexpr (std::same_as<Structure, SimplifyBound>) {
      each("distance", value.distance);
      each("in_world_units", value.in_world_units);
    } else if constexpr (std::same_as<Structure, TriangleCount>) {
      each("amount", value.amount);
      each("in_percent", value.in_percent);
    } else if constexpr (std::same_as<Structure, SimplifyChoice>) {
      each("within", value.within);
      each("triangles", value.triangles);
    } else if constexpr (std::same_as<Structure, FilterStep>) {
      each("filter", value.filter);
      each("width", value.width);
    } else if constexpr (std::same_as<Structure, BlurStep>) {
      each("kind", value.kind);
      each("width", value.width);
      each("in_world_units", value.in_world_units);
    } else if constexpr (std::same_as<Structure, LeastPiece>) {
      each("measure", value.measure);
      each("amount", value.amount);
      each("in_world_units", value.in_world_units);
    } else if constexpr (std::same_as<Structure, PieceChoice>) {
      each("least", value.least);
      each("fill_cavities", value.fill_cavities);
      each("largest", value.largest);
      each("split", value.split);
    } else if constexpr (std::same_as<Structure, SmoothChoice>) {
      each("passes", value.passes);
      each("method", value.method);
      each("pass_band", value.pass_band);
    } else if constexpr (std::same_as<Structure, ClipPlane>) {
      each("normal", value.normal);
      each("offset", value.offset);
    } else if constexpr (std::same_as<Structure, FieldFileOptions>) {
      each("half", value.as_half);
    } else if constexpr (std::same_as<Structure, PictureFileOptions>) {
      each("width", value.width);
      each("height", value.height);
      each("azimuth", value.angles.azimuth);
      each("elevation", value.angles.elevation);
      each("distance", value.angles.distance);
      each("look_at", value.angles.look_at);
    } else if constexpr (std::same_as<Structure, OutputFileJob>) {
      each("path", value.path);
      each("iso", value.isos);
      each("grid", value.grid);
    } else {
      visit_job(value, each);
    }
  }

  template <class Job, class Visitor>
  static void visit_job(Job& job, Visitor& each) {
    each("input", job.source.input);
    each("input_format", job.source.read.format);
    each("grid", job.source.read.grid);
    each("more_grids", job.source.more_grids);
    each("volume", job.source.read.volume);
    each("component", job.source.read.component);
    each("raw", job.source.read.raw);
    each("axis_order", job.source.read.axis_order);
    each("no_data", job.source.read.no_data);
    each("spacing", job.source.read.spacing);
    each("origin", job.source.read.origin);
    each("inside", job.source.read.kind);
    each("away_from_zero", job.source.away_from_zero);
    each("particles", job.source.particles);
    each("attributes", job.source.attributes);
    each("filters", job.source.filters);
    each("blurs", job.source.blurs);
    each("resolution", job.source.resolution);
    each("voxel_size", job.source.voxel_size);
    each("kernel", job.source.kernel);
    each("roi", job.source.roi);
    each("roi_snap", job.source.roi_snap);
    each("clip", job.source.clip);
    each("space", job.source.placement.space);
    each("up", job.source.placement.up);
    each("turned_to_y_up", job.source.placement.turn_z_up_to_y_up);
    each("turned_to_z_up", job.source.placement.turn_y_up_to_z_up);
    each("scale", job.source.placement.scale);
    each("unit", job.source.placement.unit);
    each("to_unit", job.source.placement.to_unit);
    each("to_space", job.source.placement.to_space);
    each("center", job.source.placement.center);
    each("method", job.surface.method);
    each("nan", job.surface.nan);
    each("cap", job.surface.cap);
    each("voxel_faces", job.surface.voxel_faces);
    each("relaxations", job.surface.relaxations);
    each("normals", job.normals);
    each("colour", job.colour);
    each("label_names", job.label_names);
    each("opacity", job.opacity);
    each("pieces", job.pieces);
    each("smooth", job.smooth);
    each("simplify", job.simplify);
    each("error", job.error);
    each("verify", job.verify);
    each("backend", job.backend.backend);
    each("device", job.backend.gpu.device);
    each("gpu_memory", job.backend.gpu.memory_bytes);
    each("empty", job.empty);
    each("format", job.format);
    each("ascii", job.ascii);
    each("compression", job.packing.compression);
    each("quantize", job.packing.quantize);
    each("position_bits", job.packing.position_bits);
    each("optimize_order", job.packing.optimize_order);
    each("field_file", job.field_file);
    each("picture_file", job.picture_file);
    each("outputs", job.outputs);
  }
};

}  // namespace isoextract::convert
