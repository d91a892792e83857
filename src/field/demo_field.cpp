// Sources of the formulas: the gyroid, Schoen (1970); the test signal, Marschner and Lobb, "An evaluation of
// reconstruction filters for volume rendering", IEEE Visualization 1994, equations 3 and 4; splitmix64, Steele, Lea and
// Flood, OOPSLA 2014.
#include "field/demo_field.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include "base/buffer.hpp"

namespace isoextract {
namespace {

constexpr double kPi = std::numbers::pi;

// World coordinates of the samples along one axis; the same for all three.
using Axis = std::vector<double>;

// Fills one row (all x) of the field at (y, z) = (axis[j], axis[k]).
using FillRow = std::function<void(std::size_t j, std::size_t k, float* row)>;

FillRow pointwise(const Axis& axis, double (*value)(double x, double y, double z)) {
  return [&axis, value](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < axis.size(); ++i) row[i] = static_cast<float>(value(axis[i], axis[j], axis[k]));
  };
}

FillRow sphere(const Axis& axis) {
  return [&axis](std::size_t j, std::size_t k, float* row) {
    const double yz = axis[j] * axis[j] + axis[k] * axis[k];
    for (std::size_t i = 0; i < axis.size(); ++i) {
      row[i] = static_cast<float>(0.7 - std::sqrt(axis[i] * axis[i] + yz));
    }
  };
}

FillRow torus(const Axis& axis) {
  return pointwise(axis, [](double x, double y, double z) { return 0.25 - std::hypot(std::hypot(x, y) - 0.6, z); });
}

// Four periods along each axis. The sines and cosines depend on one coordinate each, so they are tabulated.
FillRow gyroid(const Axis& axis) {
  std::vector<double> sine;
  std::vector<double> cosine;
  for (const double c : axis) {
    sine.push_back(std::sin(4 * kPi * c));
    cosine.push_back(std::cos(4 * kPi * c));
  }
  return [s = std::move(sine), c = std::move(cosine)](std::size_t j, std::size_t k, float* row) {
    const double yz = s[j] * c[k];
    for (std::size_t i = 0; i < s.size(); ++i) row[i] = static_cast<float>(s[i] * c[j] + yz + s[k] * c[i]);
  };
}

FillRow marschner_lobb(const Axis& axis) {
  return pointwise(axis, [](double x, double y, double z) {
    constexpr double kFrequency = 6;
    constexpr double kAlpha = 0.25;
    const double ring = std::cos(2 * kPi * kFrequency * std::cos(kPi * std::hypot(x, y) / 2));
    return (1 - std::sin(kPi * z / 2) + kAlpha * (1 + ring)) / (2 * (1 + kAlpha));
  });
}

FillRow metaballs(const Axis& axis) {
  return pointwise(axis, [](double x, double y, double z) {
    constexpr std::array<std::array<double, 4>, 5> kBalls{{{-0.35, -0.2, 0.1, 0.35},
                                                           {0.3, -0.3, -0.15, 0.3},
                                                           {0.1, 0.35, 0.2, 0.32},
                                                           {-0.15, 0.1, -0.45, 0.22},
                                                           {0.45, 0.2, 0.45, 0.18}}};
    double sum = -1;
    for (const auto& [bx, by, bz, radius] : kBalls) {
      const double d2 = (x - bx) * (x - bx) + (y - by) * (y - by) + (z - bz) * (z - bz);
      sum += radius * radius / (d2 + 0.01);
    }
    return sum;
  });
}

// Independent uniform values in [-1, 1): every case of every table, and every ambiguity, many times over.
FillRow random(const Axis& axis) {
  return [n = axis.size()](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < n; ++i) {
      std::uint64_t h = (i + n * (j + n * k) + 1) * 0x9E3779B97F4A7C15ULL;
      h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
      h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
      row[i] = static_cast<float>(static_cast<double>((h ^ (h >> 31)) >> 40) * 0x1p-23 - 1);
    }
  };
}

struct Demo {
  DemoDescription description;
  FillRow (*make)(const Axis&);
};

constexpr std::array kDemos{
    Demo{{"sphere", "0.7 - |p|: radius 0.7", 0}, sphere},
    Demo{{"torus", "radii 0.6 and 0.25 around the z axis", 0}, torus},
    Demo{{"gyroid", "sin x cos y + sin y cos z + sin z cos x, four periods; leaves the data", 0}, gyroid},
    Demo{{"marschner-lobb", "the resampling test signal of 1994 (f = 6, alpha = 0.25); leaves the data", 0.5},
         marschner_lobb},
    Demo{{"metaballs", "five blended balls", 0}, metaballs},
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

constexpr std::string_view kHint = "isoextract help demo lists the demo fields and their keys";
constexpr int kDefaultSize = 64;
constexpr int kMaxSize = 2048;

// "size=256" -> 256
Result<int> parse_size(std::string_view spec, std::string_view setting) {
  const std::size_t equals = setting.find('=');
  if (setting.substr(0, equals) != "size" || equals == std::string_view::npos) {
    return fail(ErrorKind::usage, fmt::format("{}: expected size=N, found '{}'", spec, setting), std::string(kHint));
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
                std::string(kHint));
  }
  const Result<int> size = parse_settings(spec, settings);
  if (!size) return tl::unexpected(size.error());
  return DemoSpec{name, *size};
}

Result<ScalarField> make_demo_field(std::string_view spec, const Limits& limits, Progress* progress) {
  const Result<DemoSpec> parsed = parse_demo_spec(spec);
  if (!parsed) return tl::unexpected(parsed.error());
  const auto n = static_cast<std::size_t>(parsed->size);
  const std::uint64_t bytes = n * n * n * sizeof(float);
  if (auto fits = check_memory(bytes, limits, fmt::format("{}: {}^3 f32 samples", spec, n)); !fits) {
    return tl::unexpected(fits.error());
  }

  const double spacing = 2.0 / (parsed->size - 1);
  Axis axis(n);
  for (std::size_t i = 0; i < n; ++i) axis[i] = -1 + spacing * static_cast<double>(i);

  auto values = std::make_shared<Buffer<float>>(n * n * n);
  const FillRow fill = find_demo(parsed->name)->make(axis);
  if (progress != nullptr) progress->begin("making the demo field", n);
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t k) {
    for (std::size_t j = 0; j < n; ++j) fill(j, k, values->data() + n * (j + n * k));
    if (progress != nullptr) progress->advance(1);
  });

  ScalarField field;
  field.name = std::string(parsed->name);
  field.source = std::string(spec);
  field.format = "demo";
  field.index_to_world = {glm::dmat3(spacing), glm::dvec3(-1)};
  const float* data = values->data();
  field.samples = DenseSamples{SampleType::f32, glm::ivec3(parsed->size), std::move(values), data};
  return field;
}

}  // namespace isoextract
