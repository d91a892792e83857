#include "points/detail/selection_program.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "base/nearest_name.hpp"
#include "base/printable.hpp"

namespace isoextract::points {
namespace {

constexpr std::size_t kListedNames = 100;

// A value on the stack while the program is made.
struct Operand {
  enum class Kind {
    number,   // float64
    single,   // float32: an attribute alone
    written,  // a number as written
    condition,
    unknown,  // a name of no attribute: a word, or an error
    words,
    vector,
  };
  Kind kind = Kind::number;
  const SelectionStep* step = nullptr;  // where the value comes from
  const ParticleAttribute* attribute = nullptr;
  const ParticleWords* words = nullptr;
  std::size_t constant = 0;  // index of the instruction, if written

  [[nodiscard]] bool is_number() const { return kind == Kind::number || kind == Kind::single || kind == Kind::written; }
};

// Translates a condition for one set of particles; throws Error within this file only.
class Binder {
 public:
  Binder(const ParticleSet& particles, const SelectionExpression& condition)
      : particles_(particles), condition_(condition) {}

  [[nodiscard]] SelectionProgram bind() {
    for (const SelectionStep& step : condition_.steps()) add(step);
    const Operand result = pop();
    if (result.kind != Operand::Kind::condition) wants(result, "a condition such as type == 2");
    return std::move(program_);
  }

 private:
  using Kind = Operand::Kind;
  using Op = SelectionOp;

  [[noreturn]] void fail_at(const SelectionStep& step, const std::string& message, const std::string& hint = {}) const {
    throw Error{ErrorCode::input, fmt::format("{}: {}", particles_.label, message),
                fmt::format("{}{}{}", hint, hint.empty() ? "" : "; ", condition_.mark(step.offset))};
  }

  [[noreturn]] void wants(const Operand& operand, std::string_view expected) const {
    const std::string name = printable(operand.step->word, 80);
    switch (operand.kind) {
      case Kind::unknown: refuse_unknown(*operand.step);
      case Kind::words:
        fail_at(*operand.step, fmt::format("expected {}, found '{}', which holds words", expected, name),
                "compare words by ==, != or 'in', and without arithmetic");
      case Kind::vector:
        fail_at(*operand.step,
                fmt::format("expected {}, found '{}', which has {} components", expected, name,
                            operand.attribute->components),
                fmt::format("write {0}[0] for a component, |{0}| for the length", name));
      case Kind::condition: fail_at(*operand.step, fmt::format("expected {}, found a condition", expected));
      case Kind::number:
      case Kind::single:
      case Kind::written: break;
    }
    fail_at(*operand.step, fmt::format("expected {}, found a number", expected));
  }

  [[noreturn]] void refuse_unknown(const SelectionStep& step) const {
    std::vector<std::string> names{"x", "y", "z"};
    for (const ParticleAttribute& attribute : particles_.attributes) names.push_back(attribute.name);
    for (const ParticleWords& words : particles_.words) names.push_back(words.name);
    std::string list;
    for (std::size_t i = 0; i < names.size() && i < kListedNames; ++i) {
      list += (i == 0 ? "" : ", ") + printable(names[i], 80);
    }
    fail_at(step, fmt::format("there is no attribute '{}'{}", printable(step.word, 80), did_you_mean(step.word, names)),
            fmt::format("a condition can have the names {}; isoextract info lists all attributes", list));
  }

  void push(SelectionInstruction instruction, Operand operand) {
    program_.instructions.push_back(std::move(instruction));
    stack_.push_back(operand);
    program_.depth = std::max(program_.depth, stack_.size());
  }

  Operand pop() {
    const Operand top = stack_.back();
    stack_.pop_back();
    return top;
  }

  Operand pop_number() {
    const Operand top = pop();
    if (!top.is_number()) wants(top, "a number");
    return top;
  }

  void pop_condition() {
    const Operand top = pop();
    if (top.kind != Kind::condition) wants(top, "a condition such as type == 2");
  }

  void add_name(const SelectionStep& step) {
    if (const auto axis = axis_of(step)) {
      return push({.op = Op::name, .component = *axis}, {.kind = Kind::number, .step = &step});
    }
    for (const std::string& name : meanings_of(step)) {
      const bool is_whole = step.component && name == step.spelled;
      const auto found = std::ranges::find(particles_.attributes, name, &ParticleAttribute::name);
      if (found != particles_.attributes.end()) return add_attribute(step, *found, is_whole);
      const auto words = std::ranges::find(particles_.words, name, &ParticleWords::name);
      if (words == particles_.words.end()) continue;
      return push({.op = Op::name, .words = &*words}, {.kind = Kind::words, .step = &step, .words = &*words});
    }
    push({}, {.kind = Kind::unknown, .step = &step});
  }

  void add_attribute(const SelectionStep& step, const ParticleAttribute& attribute, bool is_whole) {
    const std::size_t component = is_whole ? 0 : step.component.value_or(0);
    if (component >= attribute.components) {
      fail_at(step, fmt::format("expected a component below {}, found {} of '{}'", attribute.components, component,
                                printable(attribute.name, 80)));
    }
    const bool is_vector = attribute.components > 1 && (is_whole || !step.component);
    push({.op = Op::name, .component = component, .attribute = &attribute},
         {.kind = is_vector ? Kind::vector : Kind::single, .step = &step, .attribute = &attribute});
  }

  void add_unary(const SelectionStep& step, Op op) {
    const Operand operand = pop_number();
    const bool keeps_kind = op == Op::negate || op == Op::abs;
    push({.op = op}, {.kind = keeps_kind ? operand.kind : Kind::number, .step = &step, .constant = operand.constant});
  }

  void add_length(const SelectionStep& step) {
    if (stack_.back().kind != Kind::vector) return add_unary(step, Op::abs);
    const Operand vector = pop();
    program_.instructions.back() = {.op = Op::length, .attribute = vector.attribute};
    stack_.push_back({.kind = Kind::number, .step = &step});
  }

  void add_arithmetic(const SelectionStep& step) {
    const Operand right = pop_number();
    const Operand left = pop_number();
    const bool selects = step.op == Op::min || step.op == Op::max;
    const bool is_single = selects && left.kind == Kind::single && right.kind == Kind::single;
    push({.op = step.op}, {.kind = is_single ? Kind::single : Kind::number, .step = &step});
  }

  void add_comparison(const SelectionStep& step) {
    const Operand right = pop();
    const Operand left = stack_.back();
    const bool is_equality = step.op == Op::equal || step.op == Op::not_equal;
    if (left.kind == Kind::words && is_equality) return compare_words(step, right);
    stack_.pop_back();
    for (const Operand& operand : {left, right}) {
      if (!operand.is_number()) wants(operand, "a number");
    }
    if (left.kind == Kind::single && right.kind == Kind::written) round_to_float(right);
    if (right.kind == Kind::single && left.kind == Kind::written) round_to_float(left);
    push({.op = step.op}, {.kind = Kind::condition, .step = &step});
  }

  // Rounding commutes with the sign of a number.
  void round_to_float(const Operand& written) {
    double& number = program_.instructions[written.constant].number;
    number = static_cast<double>(static_cast<float>(number));
  }

  // Treats a name to the right of a word attribute as a word, even if an attribute or a coordinate has that name.
  void compare_words(const SelectionStep& step, const Operand& right) {
    const bool is_name = right.step->op == Op::name && !right.step->component;
    if (!is_name && right.step->op != Op::number) wants(right, "a word");
    program_.instructions.pop_back();  // of the word
    finish_words(step, {{.word = right.step->word}}, step.op == Op::not_equal);
  }

  void finish_words(const SelectionStep& step, const std::vector<SelectionItem>& items, bool inverted) {
    const Operand left = pop();
    SelectionInstruction& instruction = program_.instructions.back();
    instruction.matches.assign(left.words->words.size(), inverted ? 1 : 0);
    for (std::size_t w = 0; w < left.words->words.size(); ++w) {
      const auto is_it = [&](const SelectionItem& item) { return item.word == left.words->words[w]; };
      if (std::ranges::any_of(items, is_it)) instruction.matches[w] = inverted ? 0 : 1;
    }
    stack_.push_back({.kind = Kind::condition, .step = &step});
  }

  void add_set(const SelectionStep& step) {
    const Operand& left = stack_.back();
    const bool of_words = left.kind == Kind::words;
    for (const SelectionItem& item : step.items) {
      if (of_words && item.is_number && item.word.empty()) {
        fail_at(step, fmt::format("expected words, found a range of numbers; '{}' holds words",
                                  printable(left.step->word, 80)));
      }
      if (!of_words && !item.is_number && left.is_number()) {
        fail_at(step, fmt::format("expected numbers, found the word '{}'; '{}' holds numbers", printable(item.word, 80),
                                  printable(left.step->word, 80)));
      }
    }
    if (of_words) return finish_words(step, step.items, false);
    const Operand operand = pop_number();
    SelectionInstruction in_set{.op = Op::in_set};
    for (const SelectionItem& item : step.items) {
      auto interval = std::pair(item.low, item.high);
      if (operand.kind == Kind::single) {
        interval = {static_cast<double>(static_cast<float>(item.low)),
                    static_cast<double>(static_cast<float>(item.high))};
      }
      in_set.intervals.push_back(interval);
    }
    merge(in_set.intervals);
    push(std::move(in_set), {.kind = Kind::condition, .step = &step});
  }

  // Sorts intervals and joins those that meet, so that the last one that starts at or before a number decides.
  static void merge(std::vector<std::pair<double, double>>& intervals) {
    std::ranges::sort(intervals);
    std::vector<std::pair<double, double>> merged;
    for (const auto& interval : intervals) {
      if (!merged.empty() && interval.first <= merged.back().second) {
        merged.back().second = std::max(merged.back().second, interval.second);
      } else {
        merged.push_back(interval);
      }
    }
    intervals = std::move(merged);
  }

  void add(const SelectionStep& step) {
    switch (step.op) {
      case Op::number:
        return push({.op = Op::number, .number = step.number},
                    {.kind = Kind::written, .step = &step, .constant = program_.instructions.size()});
      case Op::name: return add_name(step);
      case Op::length: return add_length(step);
      case Op::negate:
      case Op::abs:
      case Op::sqrt: return add_unary(step, step.op);
      case Op::add:
      case Op::subtract:
      case Op::multiply:
      case Op::divide:
      case Op::min:
      case Op::max: return add_arithmetic(step);
      case Op::equal:
      case Op::not_equal:
      case Op::less:
      case Op::less_equal:
      case Op::greater:
      case Op::greater_equal: return add_comparison(step);
      case Op::in_set: return add_set(step);
      case Op::both:
      case Op::either: pop_condition(); [[fallthrough]];
      case Op::invert: pop_condition(); return push({.op = step.op}, {.kind = Kind::condition, .step = &step});
    }
  }

  const ParticleSet& particles_;
  const SelectionExpression& condition_;
  SelectionProgram program_;
  std::vector<Operand> stack_;
};

}  // namespace

Result<SelectionProgram> program_of(const ParticleSet& particles, const SelectionExpression& condition) {
  try {
    return Binder(particles, condition).bind();
  } catch (const Error& error) {
    return tl::unexpected(error);
  }
}

}  // namespace isoextract::points
