#include "bench/benchmark_inputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "base/buffer.hpp"
#include "field/demo_field.hpp"
#include "support/data_folder.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::bench {
namespace {

constexpr std::array kInputs{
    InputDescription{"sphere", Source::formula, "sphere", 0},
    InputDescription{"gyroid", Source::formula, "gyroid", 0},
    InputDescription{"marschner-lobb", Source::formula, "marschner-lobb", 0.5},
    InputDescription{"noise", Source::random, "random", 0},
    InputDescription{"ct", Source::file, "med/tooth.nhdr", 500},
    InputDescription{"mri", Source::file, "med/ch2.nii.gz", 60},
    InputDescription{"level-set", Source::vdb, "", 0},
    InputDescription{"fog", Source::vdb, "", 0.5},
};

BenchmarkInput named(const InputDescription& description, int size, Result<field::ScalarField> field) {
  if (!field) throw std::runtime_error(field.error().message);
  return {std::string(description.name), size, std::move(*field), description.iso, nullptr};
}

BenchmarkInput make_demo(const InputDescription& description, int size) {
  const std::string spec = fmt::format("demo:{}?size={}", description.origin, size);
  return named(description, size, field::make_demo_field(spec, Context()));
}

// Calls use(first, last) for pieces of [0, count), on all threads.
template <class F>
void in_pieces(std::size_t count, F&& use) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1U << 18U),
                    [&](const auto& range) { use(range.begin(), range.end()); });
}

double largest_distance(std::span<const float> values, double iso) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, values.size(), 1U << 18U), 0.0,
      [&](const auto& range, double largest) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          largest = std::max(largest, std::abs(static_cast<double>(values[i]) - iso));
        }
        return largest;
      },
      [](double a, double b) { return std::max(a, b); });
}

// A copy of `input` with samples of type To: convert(i) is sample i.
template <class To, class F>
BenchmarkInput with_samples(const BenchmarkInput& input, double iso, F&& convert) {
  const auto& samples = std::get<field::DenseSamples>(input.field.samples);
  auto values = std::make_shared<Buffer<To>>(samples.count());
  To* const data = values->data();
  in_pieces(samples.count(), [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) data[i] = convert(i);
  });
  BenchmarkInput result = input;
  result.iso = iso;
  result.field.samples = field::DenseSamples{field::sample_type_of<To>(), samples.dims, std::move(values), data};
  return result;
}

BenchmarkInput as_float(const BenchmarkInput& input) {
  const auto& samples = std::get<field::DenseSamples>(input.field.samples);
  return visit_sample_type(samples.type, [&]<class From>(std::type_identity<From>) {
    const auto* const from = static_cast<const From*>(samples.data);
    return with_samples<float>(input, input.iso, [from](std::size_t i) { return static_cast<float>(from[i]); });
  });
}

template <class To>
BenchmarkInput quantized(const BenchmarkInput& input) {
  const auto& samples = std::get<field::DenseSamples>(input.field.samples);
  if (samples.type != field::SampleType::f32) throw std::runtime_error("only f32 samples are quantised");
  const std::span<const float> from(static_cast<const float*>(samples.data), samples.count());
  const double iso = input.iso;
  constexpr double kHighest = std::numeric_limits<To>::max();
  const double middle = std::ceil((std::numeric_limits<To>::lowest() + kHighest) / 2);
  const double factor = (kHighest - middle) / largest_distance(from, iso);
  return with_samples<To>(input, middle - 0.5, [=](std::size_t i) {
    return static_cast<To>(middle + std::floor((static_cast<double>(from[i]) - iso) * factor));
  });
}

}  // namespace

std::span<const InputDescription> benchmark_inputs() { return kInputs; }

const InputDescription& find_input(std::string_view name) {
  const auto* const found = std::ranges::find(kInputs, name, &InputDescription::name);
  if (found == kInputs.end()) throw std::runtime_error(fmt::format("no input '{}'", name));
  return *found;
}

std::optional<BenchmarkInput> make_input(const InputDescription& description, int size) {
  switch (description.source) {
    case Source::formula: return make_demo(description, size);
    case Source::random: return make_demo(description, kRandomSize);
    case Source::vdb: return description.name == "fog" ? make_fog(size) : make_level_set(size);
    case Source::file: break;
  }
  const std::filesystem::path path = test::data_file(std::string(description.origin));
  if (!std::filesystem::exists(path)) return std::nullopt;
  return named(description, 0, volume_io::read_volume(path.string(), {}, Context()));
}

BenchmarkInput with_type(const BenchmarkInput& input, field::SampleType type) {
  if (type == input.field.type()) return input;
  switch (type) {
    case field::SampleType::f32: return as_float(input);
    case field::SampleType::u8: return quantized<std::uint8_t>(input);
    case field::SampleType::i8: return quantized<std::int8_t>(input);
    case field::SampleType::u16: return quantized<std::uint16_t>(input);
    case field::SampleType::i16: return quantized<std::int16_t>(input);
    default: throw std::runtime_error(fmt::format("no samples of type {} are made", field::sample_type_name(type)));
  }
}

void write_raw(const BenchmarkInput& input, const std::filesystem::path& path) {
  const auto& samples = std::get<field::DenseSamples>(input.field.samples);
  std::ofstream file(path, std::ios::binary);
  file.write(static_cast<const char*>(samples.data),
             static_cast<std::streamsize>(samples.count() * field::sample_size(samples.type)));
  if (!file.flush()) throw std::runtime_error(fmt::format("cannot write {}", path.string()));
}

}  // namespace isoextract::bench
