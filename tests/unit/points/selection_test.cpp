// Conditions on particles: the language, its errors, and the particles that a condition chooses.
#include "points/selection.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numeric>
#include <random>

#include "particles.hpp"

namespace isoextract::points {
namespace {

// Attributes: type 0 to 9, t 0.1 * type, v = (type, 2, -type), hole NaN for odd particles, species O, H, H, O, H, H...
ParticleSet sample_particles(std::size_t count) {
  ParticleSet set;
  set.label = "test.xyz";
  set.positions = Buffer<glm::dvec3>(count);
  for (const auto& [name, components] : {std::pair("type", 1), {"t", 1}, {"v", 3}, {"hole", 1}, {"odd name", 1}}) {
    const auto c = static_cast<std::size_t>(components);
    set.attributes.push_back({name, c, Buffer<float>(count * c)});
  }
  set.words.push_back({"species", {"O", "H", "x"}, Buffer<std::uint32_t>(count)});
  for (std::size_t i = 0; i < count; ++i) {
    const auto type = static_cast<float>(i * 7 % 10);
    set.positions[i] = glm::dvec3(static_cast<double>(i), 0.5, -1e300);
    set.attributes[0].values[i] = type;
    set.attributes[1].values[i] = static_cast<float>(0.1 * static_cast<double>(type));
    set.attributes[2].values[3 * i] = type;
    set.attributes[2].values[3 * i + 1] = 2;
    set.attributes[2].values[3 * i + 2] = -type;
    set.attributes[3].values[i] = i % 2 == 1 ? std::numeric_limits<float>::quiet_NaN() : 1;
    set.attributes[4].values[i] = static_cast<float>(i);
    set.words[0].indices[i] = i % 3 == 0 ? 0 : 1;
  }
  return set;
}

Result<std::vector<std::uint32_t>> chosen(const ParticleSet& set, const std::string& text) {
  const auto condition = TRY(SelectionExpression::parse(text));
  const auto indices = TRY(choose_particles(set, condition, Context()));
  return std::vector<std::uint32_t>(indices->values.begin(), indices->values.end());
}

// Returns the message, and the place that the hint shows.
std::string told(const Error& error) {
  const std::string hint = error.hint.steps.front().text;
  return error.message + hint.substr(hint.find('\n'));
}

std::vector<std::uint32_t> where(const ParticleSet& set, const std::function<bool(std::size_t)>& is) {
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (is(i)) indices.push_back(static_cast<std::uint32_t>(i));
  }
  return indices;
}

TEST(Selection, SelectsParticlesThatMeetTheCondition) {
  const ParticleSet set = sample_particles(40000);  // more than one range of the parallel loop
  const auto type = [](std::size_t i) { return i * 7 % 10; };
  const std::vector<std::pair<std::string, std::function<bool(std::size_t)>>> cases{
      {"type == 2", [&](std::size_t i) { return type(i) == 2; }},
      {"2 == type", [&](std::size_t i) { return type(i) == 2; }},
      {"type==2 && x>10", [&](std::size_t i) { return type(i) == 2 && i > 10; }},
      {"type in {1, 4..6, 9}",
       [&](std::size_t i) { return type(i) == 1 || (type(i) > 3 && type(i) < 7) || type(i) == 9; }},
      {"type in 3..1e2", [&](std::size_t i) { return type(i) >= 3; }},
      {"x in {-5..-1, 0, 2..4, 3..7}", [&](std::size_t i) { return i == 0 || (i > 1 && i < 8); }},
      {"t == 0.1", [&](std::size_t i) { return type(i) == 1; }},
      {"-t == -0.7 or 0.3 == abs(t)", [&](std::size_t i) { return type(i) == 7 || type(i) == 3; }},
      {"t in {0.1, 0.7}", [&](std::size_t i) { return type(i) == 7 || type(i) == 1; }},
      {"v[0] == 3", [&](std::size_t i) { return type(i) == 3; }},
      {"v.z < -4 and not v.x == 9", [&](std::size_t i) { return type(i) > 4 && type(i) != 9; }},
      {"|v| < 3", [&](std::size_t i) { return type(i) < 2; }},
      {"length(v)*length(v) > 2*49+3 || |v.z| == 1", [&](std::size_t i) { return type(i) > 6 || type(i) == 1; }},
      {"!(type > 2) || type >= 8", [&](std::size_t i) { return type(i) <= 2 || type(i) >= 8; }},
      {"type == 1 or type == 2 and x < 100", [&](std::size_t i) { return type(i) == 1 || (type(i) == 2 && i < 100); }},
      {"type - 2 - 3 == 1", [&](std::size_t i) { return type(i) == 6; }},
      {"type / 2 / 2 == 2", [&](std::size_t i) { return type(i) == 8; }},
      {"max(type, 3) == 3 && min(type, v.y) == 2", [&](std::size_t i) { return type(i) == 2 || type(i) == 3; }},
      {"sqrt(type) == 3 && z < 0", [&](std::size_t i) { return type(i) == 9; }},
      {"`odd name` == 17 || 'odd name' == 18", [&](std::size_t i) { return i == 17 || i == 18; }},
      {"hole == 1", [&](std::size_t i) { return i % 2 == 0; }},
      {"hole != 5", [&](std::size_t i) { return i % 2 == 0; }},
      {"hole in -1..2 or sqrt(-1-x) == 0 or min(hole, 0) == 0 or max(0, hole) >= 0",
       [&](std::size_t i) { return i % 2 == 0; }},
      {"!(hole == 5)", [](std::size_t) { return true; }},
      {"species == O", [](std::size_t i) { return i % 3 == 0; }},
      {"species != \"O\"", [](std::size_t i) { return i % 3 != 0; }},
      {"element in {O, 'Si', type}", [](std::size_t i) { return i % 3 == 0; }},
      {"species == x", [](std::size_t) { return false; }},
      {"symbol == type or species == 12", [](std::size_t) { return false; }},
      {"x == type", [](std::size_t i) { return i == 0 || i == 5; }},
  };
  for (const auto& [text, is] : cases) {
    const auto indices = chosen(set, text);
    ASSERT_TRUE(indices) << text << ": " << indices.error().message;
    EXPECT_EQ(*indices, where(set, is)) << text;
  }
}

TEST(Selection, ListsTheAttributesThatItNeeds) {
  const auto condition = SelectionExpression::parse("x > 1 && c_s[1] > v.y && species == O && |`x`| > a");
  ASSERT_TRUE(condition);
  const std::vector<SelectionName> names = condition->names();
  ASSERT_EQ(names.size(), 6U);
  EXPECT_EQ(names[0].names, (std::vector<std::string>{"c_s[1]", "c_s"}));
  EXPECT_EQ(names[1].names, (std::vector<std::string>{"v.y", "v"}));
  EXPECT_EQ(names[2].names, (std::vector<std::string>{"species", "element", "symbol"}));
  EXPECT_EQ(names[3].names, std::vector<std::string>{"O"});
  EXPECT_EQ(names[4].names, std::vector<std::string>{"x"});
  for (std::size_t i = 0; i < names.size(); ++i) EXPECT_EQ(names[i].required, i != 3) << i;
}

TEST(Selection, MarksThePositionOfErrors) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "expected a condition such as type == 2, found the end\n    \n    ^"},
      {"type = 2", "expected '==', found '='\n    type = 2\n         ^"},
      {"type == ", "expected a number or the name of an attribute, found the end\n    type == \n            ^"},
      {"type == 2 & x > 1", "expected '&&', found '&'\n    type == 2 & x > 1\n              ^"},
      {"(type == 2", "expected ')', found the end\n    (type == 2\n              ^"},
      {"0 < x < 5", "expected one comparison; join several by 'and', found '<'\n    0 < x < 5\n          ^"},
      {"type == 2 3", "expected 'and', 'or' or the end, found '3'\n    type == 2 3\n              ^"},
      {"v.w > 1", "expected one of the components x, y and z, found 'w'\n    v.w > 1\n      ^"},
      {"sin(x) > 1",
       "expected one of the functions abs, sqrt, length, min and max, found 'sin'\n    sin(x) > 1\n    ^"},
      {"x in 5..1", "expected a range from the smaller to the larger number, found '1'\n    x in 5..1\n            ^"},
      {"x > 'a", "expected a closing ', found the end\n    x > 'a\n        ^"},
      {"x > 1e999", "expected a number that fits 64-bit floats, found '1e999'\n    x > 1e999\n        ^"},
      {"\xC3\xA4 > 1 @", "expected a name, a number or an operator, found '@'\n    \xC3\xA4 > 1 @\n          ^"},
  };
  for (const auto& [text, message] : cases) {
    const auto condition = SelectionExpression::parse(text);
    ASSERT_FALSE(condition) << text;
    EXPECT_EQ(condition.error().code, ErrorCode::usage) << text;
    EXPECT_EQ(told(condition.error()), message);
  }
}

TEST(Selection, MarksNamesThatDoNotFitTheParticles) {
  const ParticleSet set = sample_particles(3);
  const std::vector<std::pair<std::string, std::string>> cases{
      {"tyqe == 2", "test.xyz: there is no attribute 'tyqe' (did you mean 'type'?)\n    tyqe == 2\n    ^"},
      {"type == O", "test.xyz: there is no attribute 'O'\n    type == O\n            ^"},
      {"v > 2", "test.xyz: expected a number, found 'v', which has 3 components\n    v > 2\n    ^"},
      {"v[3] > 2", "test.xyz: expected a component below 3, found 3 of 'v'\n    v[3] > 2\n    ^"},
      {"species > 2", "test.xyz: expected a number, found 'species', which holds words\n    species > 2\n    ^"},
      {"species in 1..2",
       "test.xyz: expected words, found a range of numbers; 'species' holds words\n    species in 1..2\n            ^"},
      {"type in {O}",
       "test.xyz: expected numbers, found the word 'O'; 'type' holds numbers\n    type in {O}\n         ^"},
      {"type", "test.xyz: expected a condition such as type == 2, found a number\n    type\n    ^"},
      {"type and x > 1", "test.xyz: expected a condition such as type == 2, found a number\n    type and x > 1\n    ^"},
      {"(x > 1) + 1 > 2", "test.xyz: expected a number, found a condition\n    (x > 1) + 1 > 2\n       ^"},
  };
  for (const auto& [text, message] : cases) {
    const auto indices = chosen(set, text);
    ASSERT_FALSE(indices) << text;
    EXPECT_EQ(indices.error().code, ErrorCode::input) << text;
    EXPECT_EQ(told(indices.error()), message);
  }
  EXPECT_TRUE(chosen(sample_particles(0), "tyqe == 2"));
}

TEST(Selection, LimitsLengthAndDepth) {
  const ParticleSet set = sample_particles(100);
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '(') + "x > 1" +
           std::string(static_cast<std::size_t>(depth), ')');
  };
  EXPECT_EQ(chosen(set, nested(kMaxSelectionDepth))->size(), 98U);
  EXPECT_NE(SelectionExpression::parse(nested(kMaxSelectionDepth + 1)).error().message.find("at most 100 nested"),
            std::string::npos);
  EXPECT_FALSE(SelectionExpression::parse(std::string(60000, '-') + "x > 1"));
  EXPECT_FALSE(SelectionExpression::parse(std::string(60000, '!') + "x > 1"));
  EXPECT_FALSE(SelectionExpression::parse("x > 1" + std::string(kMaxSelectionBytes, ' ')));
  std::string chain = "x == 0";
  while (chain.size() < 60000) chain += "||x==7";
  EXPECT_EQ(chosen(set, chain)->size(), 2U);
  std::string sum = "x";
  while (sum.size() < 60000) sum += "+1-1";
  EXPECT_EQ(chosen(set, sum + " > 97.5")->size(), 2U);
}

// A random condition as text, beside a function that evaluates it for one particle.
class RandomCondition {
 public:
  RandomCondition(const ParticleSet& set, unsigned seed) : set_(set), engine_(seed) {}

  struct Number {
    std::string text;
    std::function<double(std::size_t)> value;
  };
  struct Condition {
    std::string text;
    std::function<bool(std::size_t)> value;
  };

  Condition condition(int depth) {
    const int kind = depth > 0 ? below(5) : 4;
    if (kind == 0) {
      const Condition a = condition(depth - 1);
      return {"!(" + a.text + ")", [a](std::size_t i) { return !a.value(i); }};
    }
    if (kind < 3) {
      const Condition a = condition(depth - 1);
      const Condition b = condition(depth - 1);
      if (kind == 1) {
        return {"(" + a.text + ") && (" + b.text + ")", [=](std::size_t i) { return a.value(i) && b.value(i); }};
      }
      return {"(" + a.text + ") or (" + b.text + ")", [=](std::size_t i) { return a.value(i) || b.value(i); }};
    }
    const Number a = number(depth);
    const Number b = number(depth);
    constexpr std::array<const char*, 6> kNames{"==", "!=", "<", "<=", ">", ">="};
    const int op = below(6);
    return {
        a.text + kNames[static_cast<std::size_t>(op)] + b.text, [=](std::size_t i) {
          const double p = a.value(i);
          const double q = b.value(i);
          if (std::isnan(p) || std::isnan(q)) return false;
          return op == 0 ? p == q : op == 1 ? p != q : op == 2 ? p < q : op == 3 ? p <= q : op == 4 ? p > q : p >= q;
        }};
  }

 private:
  int below(int end) { return static_cast<int>(engine_() % static_cast<unsigned>(end)); }

  Number number(int depth) {
    switch (depth > 0 ? below(9) : below(4)) {
      case 0: {
        const int n = below(12);
        return {std::to_string(n), [n](std::size_t) { return n; }};
      }
      case 1: return {"x", [this](std::size_t i) { return set_.positions[i].x; }};
      case 2: return {"type", [this](std::size_t i) { return static_cast<double>(set_.attributes[0].values[i]); }};
      case 3: return {"hole", [this](std::size_t i) { return static_cast<double>(set_.attributes[3].values[i]); }};
      case 4: {
        const Number a = number(depth - 1);
        return {"abs(-" + wrapped(a) + ")", [a](std::size_t i) { return std::abs(a.value(i)); }};
      }
      case 5: return join(depth, " + ", [](double a, double b) { return a + b; });
      case 6: return join(depth, " - ", [](double a, double b) { return a - b; });
      case 7: return join(depth, " * ", [](double a, double b) { return a * b; });
      default: return join(depth, " / ", [](double a, double b) { return a / b; });
    }
  }

  static std::string wrapped(const Number& number) { return "(" + number.text + ")"; }

  Number join(int depth, const std::string& sign, double (*op)(double, double)) {
    const Number a = number(depth - 1);
    const Number b = number(depth - 1);
    return {wrapped(a) + sign + wrapped(b), [=](std::size_t i) { return op(a.value(i), b.value(i)); }};
  }

  const ParticleSet& set_;
  std::mt19937 engine_;
};

TEST(Selection, AgreesWithANaiveEvaluation) {
  const ParticleSet set = sample_particles(1100);
  for (unsigned seed = 0; seed < 400; ++seed) {
    RandomCondition random(set, seed);  // its functions refer to it
    const auto [text, value] = random.condition(5);
    const auto indices = chosen(set, text);
    ASSERT_TRUE(indices) << text << ": " << indices.error().message;
    EXPECT_EQ(*indices, where(set, value)) << text;
  }
}

TEST(Selection, SurvivesAnyText) {
  const ParticleSet set = sample_particles(5);
  const std::vector<std::string> parts{"x",     "type", "v",  "species", "O", "1",   "2.5",  "..",     ".",
                                       "(",     ")",    "{",  "}",       "[", "]",   ",",    "|",      "||",
                                       "&&",    "==",   "!=", "<",       "!", "-",   "in",   "not",    "or",
                                       "'a b'", "`t`",  "+",  "/",       "*", "abs", "\xFF", "length", "min"};
  std::mt19937 engine(1);
  std::size_t valid = 0;
  for (int round = 0; round < 20000; ++round) {
    std::string text;
    const auto count = engine() % 9;
    for (unsigned k = 0; k <= count; ++k) text += parts[engine() % parts.size()] + (engine() % 3 == 0 ? " " : "");
    const auto indices = chosen(set, text);
    if (indices) ++valid;
    EXPECT_TRUE(indices || !indices.error().message.empty());
  }
  EXPECT_GT(valid, 0U);
}

TEST(Selection, CopiesAttributesOfSelectedParticles) {
  ParticleSet set = sample_particles(10);
  set.box = SimulationBox{.origin = glm::dvec3(1, 2, 3), .periodic = {true, false, true}};
  const std::vector<std::uint32_t> indices{1, 4, 9};
  const auto taken = take_particles(set, indices, Context());
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->label, set.label);
  EXPECT_EQ(taken->box, set.box);
  ASSERT_EQ(taken->size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(taken->positions[k], set.positions[indices[k]]);
    EXPECT_EQ(taken->attributes[4].values[k], static_cast<float>(indices[k]));
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_EQ(taken->attributes[2].values[3 * k + c], set.attributes[2].values[3 * indices[k] + c]);
    }
    EXPECT_EQ(taken->words[0].indices[k], set.words[0].indices[indices[k]]);
  }
  const Context small{MemoryBudget(16)};
  EXPECT_EQ(take_particles(set, indices, small).error().code, ErrorCode::out_of_memory);
}

TEST(Selection, QuotesWordsThatContainQuotes) {
  for (const std::string& word : std::vector<std::string>{"O", "O5'", "O\"", "a'b\"c"}) {
    const std::string condition = "species == " + word_in_selection(word);
    EXPECT_TRUE(SelectionExpression::parse(condition)) << condition;
  }
  EXPECT_EQ(word_in_selection("a'b\"c"), "`a'b\"c`");
}

}  // namespace

}  // namespace isoextract::points
