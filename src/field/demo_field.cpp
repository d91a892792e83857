// The formulas are in demo_formulas.hpp.
#include "field/demo_field.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/hash.hpp"
#include "base/nearest_name.hpp"
#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"
#include "field/demo_formulas.hpp"

namespace isoextract::field {
namespace {

// World coordinates of the samples along an axis; all three axes are the same.
using Axis = std::vector<double>;

// Fills one row (all x) of the field at (y, z) = (axis[j], axis[k]).
using FillRow = std::function<void(std::size_t j, std::size_t k, float* row)>;

template <class Formula>
FillRow pointwise(const Axis& axis) {
  return [&axis](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < axis.size(); ++i) row[i] = static_cast<float>(Formula{}(axis[i], axis[j], axis[k]));
  };
}

// Each sine and cosine depends on one coordinate only, so tables hold them.
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

// Independent uniform values in [-1, 1): they contain every case and every ambiguity of the case tables many times.
FillRow random(const Axis& axis) {
  return [n = axis.size()](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint64_t h = splitmix64(i + n * (j + n * k));
      row[i] = static_cast<float>(static_cast<double>(h >> 40) * 0x1p-23 - 1);
    }
  };
}

// The moving fields at times other than 0.

FillRow moved_sphere(const Axis& axis, double time) {
  const double height = 0.25 * std::sin(2 * formulas::kPi * time);
  return [&axis, height](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < axis.size(); ++i) {
      row[i] = static_cast<float>(formulas::Sphere{}(axis[i], axis[j], axis[k] - height));
    }
  };
}

// Moves along x by one period of the gyroid.
FillRow moved_gyroid(const Axis& axis, double time) {
  using formulas::Gyroid;
  const auto angle = [&axis](std::size_t i) { return Gyroid::kFrequency * axis[i]; };
  std::vector<std::array<double, 2>> along_x;
  std::vector<std::array<double, 2>> across;
  for (std::size_t i = 0; i < axis.size(); ++i) {
    const double shifted = angle(i) - 2 * formulas::kPi * time;
    along_x.push_back({std::sin(shifted), std::cos(shifted)});
    across.push_back({std::sin(angle(i)), std::cos(angle(i))});
  }
  return [x = std::move(along_x), yz = std::move(across)](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      row[i] = static_cast<float>(Gyroid::sum(x[i][0], x[i][1], yz[j][0], yz[j][1], yz[k][0], yz[k][1]));
    }
  };
}

// The balls circle the z axis at different speeds, so that they merge and separate.
FillRow moved_metaballs(const Axis& axis, double time) {
  constexpr std::array kTurns{1, -1, 2, -2, -1};
  formulas::Metaballs::Balls balls = formulas::Metaballs::kBalls;
  for (std::size_t b = 0; b < balls.size(); ++b) {
    const double angle = 2 * formulas::kPi * kTurns[b] * time;
    const double x = balls[b][0];
    const double y = balls[b][1];
    balls[b][0] = x * std::cos(angle) - y * std::sin(angle);
    balls[b][1] = x * std::sin(angle) + y * std::cos(angle);
  }
  return [&axis, balls](std::size_t j, std::size_t k, float* row) {
    for (std::size_t i = 0; i < axis.size(); ++i) {
      row[i] = static_cast<float>(formulas::Metaballs::blend(balls, axis[i], axis[j], axis[k]));
    }
  };
}

struct Demo {
  DemoDescription description;
  FillRow (*make)(const Axis&);
  FillRow (*make_moved)(const Axis&, double time);  // null if the field does not move
};

constexpr std::array kDemos{
    Demo{{"sphere", "0.7 - |p|: radius 0.7", 0, "rises and sinks by 0.25 along z"},
         pointwise<formulas::Sphere>,
         moved_sphere},
    Demo{{"torus", "radii 0.6 and 0.25 around the z axis", 0, ""}, pointwise<formulas::Torus>, nullptr},
    Demo{{"gyroid", "sin x cos y + sin y cos z + sin z cos x, four periods; leaves the data", 0,
          "moves along x by one period"},
         gyroid,
         moved_gyroid},
    Demo{{"marschner-lobb", "the resampling test signal of 1994 (f = 6, alpha = 0.25); leaves the data", 0.5, ""},
         pointwise<formulas::MarschnerLobb>,
         nullptr},
    Demo{{"metaballs", "five blended balls", 0, "circle around the z axis, merge and part"},
         pointwise<formulas::Metaballs>,
         moved_metaballs},
    Demo{{"random", "independent uniform values in [-1, 1): topology of extreme complexity", 0, ""}, random, nullptr},
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

template <class T>
std::optional<T> parse_number(std::string_view text) {
  T number{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

Result<void> set_size(std::string_view spec, std::string_view text, DemoSpec& demo) {
  const auto size = parse_number<int>(text);
  if (!size || *size < 2 || *size > kMaxSize) {
    return fail(ErrorCode::usage,
                fmt::format("{}: size must be a whole number from 2 to {}, found '{}'", spec, kMaxSize, text));
  }
  demo.size = *size;
  return {};
}

Result<void> set_time(std::string_view spec, std::string_view text, DemoSpec& demo) {
  if (find_demo(demo.name)->make_moved == nullptr) {
    std::vector<std::string_view> moving;
    for (const DemoDescription& description : kDescriptions) {
      if (!description.motion.empty()) moving.push_back(description.name);
    }
    return fail(ErrorCode::usage,
                fmt::format("{}: the field {} does not move, so it has no time; the moving fields are {}", spec,
                            demo.name, fmt::join(moving, ", ")),
                {Remedy::see, Setting::demo_fields});
  }
  const auto time = parse_number<double>(text);
  if (!time || !std::isfinite(*time)) {
    return fail(ErrorCode::usage, fmt::format("{}: time must be a number, found '{}'", spec, text));
  }
  // Rounding can turn a phase just below 1 into 1, which equals 0.
  const double phase = *time - std::floor(*time);
  demo.time = phase < 1 ? phase : 0;
  return {};
}

// Parses "size=256&time=0.5".
Result<void> parse_settings(std::string_view spec, std::string_view settings, DemoSpec& demo) {
  while (!settings.empty()) {
    const std::size_t end = settings.find('&');
    const std::string_view setting = settings.substr(0, end);
    const std::size_t equals = std::min(setting.find('='), setting.size());
    const std::string_view key = setting.substr(0, equals);
    if (equals == setting.size() || (key != "size" && key != "time")) {
      return fail(ErrorCode::usage, fmt::format("{}: expected size=N or time=T, found '{}'", spec, setting),
                  {Remedy::see, Setting::demo_fields});
    }
    const std::string_view text = setting.substr(equals + 1);
    auto set = key == "size" ? set_size(spec, text, demo) : set_time(spec, text, demo);
    if (!set) return set;
    settings.remove_prefix(end == std::string_view::npos ? settings.size() : end + 1);
  }
  return {};
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
    std::vector<std::string> names;
    for (const DemoDescription& demo : kDescriptions) names.emplace_back(demo.name);
    return fail(ErrorCode::usage,
                fmt::format("{}: there is no demo field '{}'{}; the demo fields are {}", spec, name,
                            did_you_mean(name, names), fmt::join(names, ", ")),
                {Remedy::see, Setting::demo_fields});
  }
  DemoSpec demo{name, kDefaultSize, 0};
  TRY(parse_settings(spec, settings, demo));
  return demo;
}

Result<ScalarField> make_demo_field(std::string_view spec, const Context& context) {
  const DemoSpec parsed = TRY(parse_demo_spec(spec));
  const auto n = static_cast<std::size_t>(parsed.size);
  auto samples = TRY(make_reserved_buffer<float>(n * n * n, context, fmt::format("{}: {}^3 f32 samples", spec, n)));

  const double spacing = 2.0 / (parsed.size - 1);
  Axis axis(n);
  for (std::size_t i = 0; i < n; ++i) axis[i] = -1 + spacing * static_cast<double>(i);

  float* const values = samples->values.data();
  const Demo& demo = *find_demo(parsed.name);
  const FillRow fill = parsed.time == 0 ? demo.make(axis) : demo.make_moved(axis, parsed.time);
  context.progress().begin("making the demo field", n);
  for_each_index(n, [&](std::size_t k) {
    if (context.cancelled()) return;
    for (std::size_t j = 0; j < n; ++j) fill(j, k, values + n * (j + n * k));
    context.progress().advance(1);
  });
  TRY(context.check());

  ScalarField field;
  field.name = std::string(parsed.name);
  field.source = std::string(spec);
  field.format = "demo";
  field.index_to_world = {glm::dmat3(spacing), glm::dvec3(-1)};
  field.samples = DenseSamples{SampleType::f32, glm::ivec3(parsed.size), std::move(samples), values};
  return field;
}

}  // namespace isoextract::field
