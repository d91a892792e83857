// The formulas are in demo_formulas.hpp.
#include "field/demo_field.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include "base/hash.hpp"
#include "base/reserved_buffer.hpp"
#include "field/demo_formulas.hpp"

namespace isoextract::field {
namespace {

// World coordinates of the samples along one axis; the same for all three.
using Axis = std::vector<double>;

// Fills one row (all x) of the field at (y, z) = (axis[j], axis[k]).
using FillRow = std::function<void(std::size_t j, std::size_t k, float* row)>;

template <class Formula>
FillRow pointwise(const Axis& axis) {
  return [&axis](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < axis.size(); ++i) row[i] = static_cast<float>(Formula{}(axis[i], axis[j], axis[k]));
  };
}

// The sines and cosines depend on one coordinate each, so they are tabulated.
FillRow gyroid(const Axis& axis) {
  using formulas::Gyroid;
  std::vector<double> sine;
  std::vector<double> cosine;
  for (const double c : axis) {
    sine.push_back(std::sin(Gyroid::kFrequency * c));
    cosine.push_back(std::cos(Gyroid::kFrequency * c));
  }
  return [s = std::move(sine), c = std::move(cosine)](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < s.size(); ++i) {
      row[i] = static_cast<float>(Gyroid::sum(s[i], c[i], s[j], c[j], s[k], c[k]));
    }
  };
}

// Independent uniform values in [-1, 1): every case of every table, and every ambiguity, many times over.
FillRow random(const Axis& axis) {
  return [n = axis.size()](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t h = splitmix64(i + n * (j + n * k));
      row[i] = static_cast<float>(static_cast<double>(h >> 40) * 0x1p-23 - 1);
    }
  };
}

struct Demo {
  DemoDescription description;
  FillRow (*make)(const Axis&);
};

constexpr std::array kDemos{
    Demo{{"sphere", "0.7 - |p|: radius 0.7", 0}, pointwise<formulas::Sphere>},
    Demo{{"torus", "radii 0.6 and 0.25 around the z axis", 0}, pointwise<formulas::Torus>},
    Demo{{"gyroid", "sin x cos y + sin y cos z + sin z cos x, four periods; leaves the data", 0}, gyroid},
    Demo{{"marschner-lobb", "the resampling test signal of 1994 (f = 6, alpha = 0.25); leaves the data", 0.5},
         pointwise<formulas::MarschnerLobb>},
    Demo{{"metaballs", "five blended balls", 0}, pointwise<formulas::Metaballs>},
    Demo{{"random", "independent uniform values in [-1, 1): the hardest topology there is", 0}, random},
};

constexpr auto kDescriptions = [] {
  std::array<DemoDescription, kDemos.size()> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = kDemos[i].description;
  return all;
}();

const Demo* find_demo(std::string_view name) {
  const auto* const found =
      std::find_if(kDemos.begin(), kDemos.end(), [&](const Demo& demo) { return demo.description.name == name; });
  return found == kDemos.end() ? nullptr : found;
}

constexpr int kDefaultSize = 64;
constexpr int kMaxSize = 2048;

// "size=256" -> 256
Result<int> parse_size(std::string_view spec, std::string_view setting) {
  const std::size_t equals = setting.find('=');
  if (setting.substr(0, equals) != "size" || equals == std::string_view::npos) {
    return fail(ErrorKind::usage, fmt::format("{}: expected size=N, found '{}'", spec, setting),
                Remedy::list_demo_fields);
  }
  const std::string_view text = setting.substr(equals + 1);
  int size = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), size);
  if (status != std::errc{} || end != text.data() + text.size() || size < 2 || size > kMaxSize) {
    return fail(ErrorKind::usage,
                fmt::format("{}: size must be a number from 2 to {}, found '{}'", spec, kMaxSize, text));
  }
  return size;
}

Result<int> parse_settings(std::string_view spec, std::string_view settings) {
  int size = kDefaultSize;
  while (!settings.empty()) {
    const std::size_t end = settings.find('&');
    const Result<int> parsed = parse_size(spec, settings.substr(0, end));
    if (!parsed) return parsed;
    size = *parsed;
    settings.remove_prefix(end == std::string_view::npos ? settings.size() : end + 1);
  }
  return size;
}

}  // namespace

std::span<const DemoDescription> demo_fields() { return kDescriptions; }

Result<DemoSpec> parse_demo_spec(std::string_view spec) {
  std::string_view name = spec;
  if (name.starts_with(kDemoPrefix)) name.remove_prefix(kDemoPrefix.size());
  const std::size_t query = name.find('?');
  const std::string_view settings = query == std::string_view::npos ? "" : name.substr(query + 1);
  name = name.substr(0, query);

  if (find_demo(name) == nullptr) {
    std::vector<std::string_view> names;
    for (const DemoDescription& demo : kDescriptions) names.push_back(demo.name);
    return fail(ErrorKind::usage,
                fmt::format("{}: no demo field '{}'; there are {}", spec, name, fmt::join(names, ", ")),
                Remedy::list_demo_fields);
  }
  const Result<int> size = parse_settings(spec, settings);
  if (!size) return tl::unexpected(size.error());
  return DemoSpec{name, *size};
}

Result<ScalarField> make_demo_field(std::string_view spec, const Context& context) {
  const Result<DemoSpec> parsed = parse_demo_spec(spec);
  if (!parsed) return tl::unexpected(parsed.error());
  const auto n = static_cast<std::size_t>(parsed->size);
  auto samples = make_reserved_buffer<float>(n * n * n, context, fmt::format("{}: {}^3 f32 samples", spec, n));
  if (!samples) return tl::unexpected(samples.error());

  const double spacing = 2.0 / (parsed->size - 1);
  Axis axis(n);
  for (std::size_t i = 0; i < n; ++i) axis[i] = -1 + spacing * static_cast<double>(i);

  float* const values = (*samples)->values.data();
  const FillRow fill = find_demo(parsed->name)->make(axis);
  context.progress().begin("making the demo field", n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t k) {
    if (context.cancelled()) return;
    for (std::size_t j = 0; j < n; ++j) fill(j, k, values + n * (j + n * k));
    context.progress().advance(1);
  });
  if (auto wanted = context.check(); !wanted) return tl::unexpected(wanted.error());

  ScalarField field;
  field.name = std::string(parsed->name);
  field.source = std::string(spec);
  field.format = "demo";
  field.index_to_world = {glm::dmat3(spacing), glm::dvec3(-1)};
  field.samples = DenseSamples{SampleType::f32, glm::ivec3(parsed->size), std::move(*samples), values};
  return field;
}

}  // namespace isoextract::field
