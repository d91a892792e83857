#include "points/selection.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "points/detail/selection_program.hpp"

namespace isoextract::points {
namespace {

constexpr std::size_t kBlock = 512;                   // particles evaluated together
constexpr std::size_t kGrain = std::size_t{1} << 14;  // a multiple of kBlock

// Evaluates a program for blocks of particles.
class Evaluator {
 public:
  Evaluator(const ParticleSet& particles, const SelectionProgram& program)
      : particles_(particles), program_(program), stack_(program.depth * kBlock) {}

  // Writes 1 for each of the particles from `first` on that fulfills the condition, else 0; at most kBlock particles.
  void run(std::size_t first, std::span<std::uint8_t> chosen) {
    double* top = stack_.data();  // behind the last block
    for (const SelectionInstruction& instruction : program_.instructions)
      top = apply(instruction, first, chosen.size(), top);
    for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = stack_[i] != 0 ? 1 : 0;
  }

 private:
  using Op = SelectionOp;

  template <class F>
  static double* fill(double* top, std::size_t count, const F& value) {
    for (std::size_t i = 0; i < count; ++i) top[i] = value(i);
    return top + kBlock;
  }
  template <class F>
  static double* change(double* top, std::size_t count, const F& value) {
    double* const last = top - kBlock;
    for (std::size_t i = 0; i < count; ++i) last[i] = value(last[i]);
    return top;
  }
  template <class F>
  static double* join(double* top, std::size_t count, const F& value) {
    double* const left = top - 2 * kBlock;
    const double* const right = top - kBlock;
    for (std::size_t i = 0; i < count; ++i) left[i] = static_cast<double>(value(left[i], right[i]));
    return top - kBlock;
  }

  // upper_bound() takes NaN as larger than all numbers, and NaN <= second is false.
  [[nodiscard]] static bool is_in(const std::vector<std::pair<double, double>>& intervals, double value) {
    const auto behind = std::ranges::upper_bound(intervals, value, {}, &std::pair<double, double>::first);
    return behind != intervals.begin() && value <= std::prev(behind)->second;
  }

  [[nodiscard]] double* load(const SelectionInstruction& instruction, std::size_t first, std::size_t count,
                             double* top) const {
    if (instruction.op == Op::number) return fill(top, count, [&](std::size_t) { return instruction.number; });
    if (instruction.words != nullptr) {
      const std::uint32_t* const words = instruction.words->indices.data() + first;
      return fill(top, count, [&](std::size_t i) { return static_cast<double>(instruction.matches[words[i]]); });
    }
    if (instruction.attribute == nullptr) {
      const glm::dvec3* const positions = particles_.positions.data() + first;
      const auto axis = static_cast<glm::length_t>(instruction.component);
      return fill(top, count, [&](std::size_t i) { return positions[i][axis]; });
    }
    const std::size_t components = instruction.attribute->components;
    const float* const values = instruction.attribute->values.data() + first * components;
    if (instruction.op == Op::name) {
      const float* const component = values + instruction.component;
      return fill(top, count, [&](std::size_t i) { return static_cast<double>(component[i * components]); });
    }
    return fill(top, count, [&](std::size_t i) {
      double sum = 0;
      for (std::size_t c = 0; c < components; ++c) {
        const auto value = static_cast<double>(values[i * components + c]);
        sum += value * value;
      }
      return std::sqrt(sum);
    });
  }

  [[nodiscard]] double* apply(const SelectionInstruction& instruction, std::size_t first, std::size_t count,
                              double* top) const {
    switch (instruction.op) {
      case Op::number:
      case Op::name:
      case Op::length: return load(instruction, first, count, top);
      case Op::negate: return change(top, count, [](double a) { return -a; });
      case Op::abs: return change(top, count, [](double a) { return std::abs(a); });
      case Op::sqrt: return change(top, count, [](double a) { return std::sqrt(a); });
      case Op::invert: return change(top, count, [](double a) { return a == 0 ? 1.0 : 0.0; });
      case Op::in_set: return change(top, count, [&](double a) { return is_in(instruction.intervals, a) ? 1.0 : 0.0; });
      case Op::add: return join(top, count, [](double a, double b) { return a + b; });
      case Op::subtract: return join(top, count, [](double a, double b) { return a - b; });
      case Op::multiply: return join(top, count, [](double a, double b) { return a * b; });
      case Op::divide: return join(top, count, [](double a, double b) { return a / b; });
      // min and max are NaN if an operand is NaN.
      case Op::min: return join(top, count, [](double a, double b) { return a < b ? a : b <= a ? b : a + b; });
      case Op::max: return join(top, count, [](double a, double b) { return a > b ? a : b >= a ? b : a + b; });
      case Op::equal: return join(top, count, [](double a, double b) { return a == b; });
      case Op::not_equal: return join(top, count, [](double a, double b) { return a < b || a > b; });
      case Op::less: return join(top, count, [](double a, double b) { return a < b; });
      case Op::less_equal: return join(top, count, [](double a, double b) { return a <= b; });
      case Op::greater: return join(top, count, [](double a, double b) { return a > b; });
      case Op::greater_equal: return join(top, count, [](double a, double b) { return a >= b; });
      case Op::both: return join(top, count, [](double a, double b) { return a != 0 && b != 0; });
      case Op::either: return join(top, count, [](double a, double b) { return a != 0 || b != 0; });
    }
    return top;
  }

  const ParticleSet& particles_;
  const SelectionProgram& program_;
  std::vector<double> stack_;
};

template <class T>
Buffer<T> values_at(const Buffer<T>& all, std::size_t components, std::span<const std::uint32_t> indices) {
  Buffer<T> taken(indices.size() * components);
  for_each_range(indices.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::copy_n(all.data() + std::size_t{indices[i]} * components, components, taken.data() + i * components);
    }
  });
  return taken;
}

}  // namespace

Result<std::shared_ptr<ReservedBuffer<std::uint32_t>>> choose_particles(const ParticleSet& particles,
                                                                        const SelectionExpression& condition,
                                                                        const Context& context) {
  const std::size_t count = particles.size();
  const std::string what = particles.label + ": particles chosen by a condition";
  if (count > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected fewer than 2^32 particles, found {}", particles.label, count));
  }
  SelectionProgram program;
  if (count > 0) program = TRY(program_of(particles, condition));
  const auto chosen = TRY(make_reserved_buffer<std::uint8_t>(count, context, what));
  std::vector<std::size_t> starts((count + kGrain - 1) / kGrain + 1);
  for_each_index(starts.size() - 1, [&](std::size_t range) {
    Evaluator evaluator(particles, program);
    const std::size_t end = std::min(count, (range + 1) * kGrain);
    for (std::size_t first = range * kGrain; first < end; first += kBlock) {
      const auto block = chosen->values.span().subspan(first, std::min(kBlock, end - first));
      evaluator.run(first, block);
      starts[range + 1] += static_cast<std::size_t>(std::ranges::count(block, 1));
    }
  });
  TRY(context.check());
  for (std::size_t range = 1; range < starts.size(); ++range) starts[range] += starts[range - 1];
  auto indices = TRY(make_reserved_buffer<std::uint32_t>(starts.back(), context, what));
  for_each_index(starts.size() - 1, [&](std::size_t range) {
    std::size_t to = starts[range];
    const std::size_t end = std::min(count, (range + 1) * kGrain);
    for (std::size_t i = range * kGrain; i < end; ++i) {
      if (chosen->values[i] != 0) indices->values[to++] = static_cast<std::uint32_t>(i);
    }
  });
  return indices;
}

Result<ParticleSet> take_particles(const ParticleSet& particles, std::span<const std::uint32_t> indices,
                                   const Context& context) {
  std::uint64_t bytes = sizeof(glm::dvec3);
  for (const ParticleAttribute& attribute : particles.attributes) bytes += attribute.components * sizeof(float);
  bytes += particles.words.size() * sizeof(std::uint32_t);
  ParticleSet taken;
  taken.memory = TRY(context.reserve(bytes * indices.size(), particles.label + ": chosen particles"));
  taken.label = particles.label;
  taken.box = particles.box;
  taken.positions = values_at(particles.positions, 1, indices);
  for (const ParticleAttribute& attribute : particles.attributes) {
    taken.attributes.push_back({attribute.name, attribute.components,
                                values_at(attribute.values, attribute.components, indices), attribute.kind});
  }
  for (const ParticleWords& words : particles.words) {
    if (words.too_many) continue;
    taken.words.push_back({words.name, words.words, values_at(words.indices, 1, indices)});
  }
  return taken;
}

}  // namespace isoextract::points
