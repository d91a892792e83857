#include "points/selection_expression.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"

namespace isoextract::points {
namespace {

bool is_name_start(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || byte >= 0x80;
}
bool is_name_byte(char c) { return is_name_start(c) || is_digit(c); }

constexpr std::array<std::string_view, 3> kSpeciesNames{"species", "element", "symbol"};

enum class TokenKind { end, number, name, quoted, mark };

struct Token {
  TokenKind kind = TokenKind::end;
  std::size_t place = 0;
  std::size_t end = 0;
  std::string text;  // without quotes
  double number = 0;
};

struct Fault {
  std::size_t place;
  std::string message;
};

// Throws Fault within this file only.
class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  [[nodiscard]] Token next() {
    while (at_ < text_.size() && std::string_view(" \t\n\r").find(text_[at_]) != std::string_view::npos) ++at_;
    Token token;
    token.place = at_;
    if (at_ < text_.size()) read(token);
    token.end = at_;
    return token;
  }

 private:
  void read(Token& token) {
    const char c = text_[at_];
    if (is_digit(c) || (c == '.' && at_ + 1 < text_.size() && is_digit(text_[at_ + 1]))) return read_number(token);
    if (is_name_start(c)) {
      token.kind = TokenKind::name;
      while (at_ < text_.size() && is_name_byte(text_[at_])) token.text += text_[at_++];
      return;
    }
    if (c == '\'' || c == '"' || c == '`') return read_quoted(token);
    token.kind = TokenKind::mark;
    constexpr std::array<std::string_view, 8> kLong{"||", "&&", "==", "!=", "<=", ">=", "..", "<>"};
    const auto two = text_.substr(at_, 2);
    if (std::ranges::find(kLong, two) != kLong.end()) {
      token.text = two;
    } else if (std::string_view("|!<>+-*/(){}[],.").find(c) != std::string_view::npos) {
      token.text = c;
    } else if (c == '=' || c == '&') {
      throw Fault{at_, fmt::format("expected '{0}{0}', found '{0}'", c)};
    } else {
      throw Fault{
          at_, fmt::format("expected a name, a number or an operator, found '{}'", printable(std::string_view(&c, 1)))};
    }
    at_ += token.text.size();
  }

  // "1..5" is two numbers and a mark.
  void read_number(Token& token) {
    token.kind = TokenKind::number;
    std::size_t last = at_;
    const auto digits = [&] {
      while (last < text_.size() && is_digit(text_[last])) ++last;
    };
    digits();
    if (last < text_.size() && text_[last] == '.' && text_.substr(last, 2) != "..") {
      ++last;
      digits();
    }
    if (last < text_.size() && (text_[last] == 'e' || text_[last] == 'E')) {
      const std::size_t sign = last + 1 < text_.size() && (text_[last + 1] == '+' || text_[last + 1] == '-') ? 1 : 0;
      if (last + 1 + sign < text_.size() && is_digit(text_[last + 1 + sign])) {
        last += 1 + sign;
        digits();
      }
    }
    token.text = text_.substr(at_, last - at_);
    const auto [end, status] = std::from_chars(text_.data() + at_, text_.data() + last, token.number);
    if (status != std::errc() || end != text_.data() + last) {
      throw Fault{at_, fmt::format("expected a number that fits 64-bit floats, found '{}'", printable(token.text, 40))};
    }
    if (last < text_.size() && is_name_start(text_[last])) {  // a word such as 1H
      while (last < text_.size() && is_name_byte(text_[last])) token.text += text_[last++];
      token.kind = TokenKind::name;
    }
    at_ = last;
  }

  void read_quoted(Token& token) {
    const char quote = text_[at_];
    const std::size_t close = text_.find(quote, at_ + 1);
    if (close == std::string_view::npos) throw Fault{at_, fmt::format("expected a closing {}, found the end", quote)};
    token.kind = TokenKind::quoted;
    token.text = text_.substr(at_ + 1, close - at_ - 1);
    at_ = close + 1;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

// A parser by recursive descent that writes postfix.
class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text), lexer_(text) { advance(); }

  [[nodiscard]] std::vector<SelectionStep> whole() {
    if (is_end()) fault("expected a condition such as type == 2");
    alternatives();
    if (!is_end()) fault("expected 'and', 'or' or the end");
    return std::move(steps_);
  }

 private:
  [[nodiscard]] bool is_end() const { return token_.kind == TokenKind::end; }
  [[nodiscard]] bool is(std::string_view mark) const { return token_.kind == TokenKind::mark && token_.text == mark; }
  [[nodiscard]] bool is_word(std::string_view word) const {
    return token_.kind == TokenKind::name && token_.text == word;
  }

  void advance() {
    end_ = token_.end;
    token_ = lexer_.next();
  }

  bool take(std::string_view mark) {
    if (!is(mark)) return false;
    advance();
    return true;
  }

  [[noreturn]] void fault(std::string_view expected) const {
    const std::string found = is_end() ? "the end" : fmt::format("'{}'", printable(token_.text, 40));
    throw Fault{token_.place, fmt::format("{}, found {}", expected, found)};
  }

  void expect(std::string_view mark) {
    if (!take(mark)) fault(fmt::format("expected '{}'", mark));
  }

  void add(SelectionOp op, std::size_t place) { steps_.push_back({.op = op, .offset = place}); }

  // Counts nested parentheses and signs while it lives.
  class Nested {
   public:
    explicit Nested(Parser& parser) : parser_(parser) {
      if (++parser_.depth_ > kMaxSelectionDepth) {
        throw Fault{parser_.token_.place,
                    fmt::format("expected at most {} nested parentheses and signs, found more", kMaxSelectionDepth)};
      }
    }
    Nested(const Nested&) = delete;
    Nested& operator=(const Nested&) = delete;
    ~Nested() { --parser_.depth_; }

   private:
    Parser& parser_;
  };

  void alternatives() {
    conjunction();
    while (is("||") || is_word("or")) {
      const std::size_t place = token_.place;
      advance();
      conjunction();
      add(SelectionOp::either, place);
    }
  }

  void conjunction() {
    negation();
    while (is("&&") || is_word("and")) {
      const std::size_t place = token_.place;
      advance();
      negation();
      add(SelectionOp::both, place);
    }
  }

  void negation() {
    if (!is("!") && !is_word("not")) return comparison();
    const Nested nested(*this);
    const std::size_t place = token_.place;
    advance();
    negation();
    add(SelectionOp::invert, place);
  }

  [[nodiscard]] std::optional<SelectionOp> comparison_at_hand() const {
    constexpr std::array<std::pair<std::string_view, SelectionOp>, 6> kComparisons{
        {{"==", SelectionOp::equal},
         {"!=", SelectionOp::not_equal},
         {"<", SelectionOp::less},
         {"<=", SelectionOp::less_equal},
         {">", SelectionOp::greater},
         {">=", SelectionOp::greater_equal}}};
    if (token_.kind != TokenKind::mark) return std::nullopt;
    for (const auto& [mark, op] : kComparisons) {
      if (token_.text == mark) return op;
    }
    return std::nullopt;
  }

  void comparison() {
    sum();
    const std::size_t place = token_.place;
    if (is_word("in")) {
      advance();
      SelectionStep step{.op = SelectionOp::in_set, .offset = place};
      step.items = items();
      steps_.push_back(std::move(step));
    } else if (const auto op = comparison_at_hand()) {
      advance();
      sum();
      add(*op, place);
    }
    if (comparison_at_hand() || is_word("in")) fault("expected one comparison; join several by 'and'");
  }

  std::vector<SelectionItem> items() {
    if (!take("{")) return {item()};
    std::vector<SelectionItem> all{item()};
    while (take(",")) all.push_back(item());
    expect("}");
    return all;
  }

  SelectionItem item() {
    SelectionItem one;
    const bool is_negative = take("-");
    if (token_.kind == TokenKind::number) {
      one.is_number = true;
      one.word = (is_negative ? "-" : "") + token_.text;
      one.low = one.high = is_negative ? -token_.number : token_.number;
      advance();
      if (take("..")) {
        one.word.clear();
        const bool is_end_negative = take("-");
        if (token_.kind != TokenKind::number) fault("expected a number at the end of the range");
        one.high = is_end_negative ? -token_.number : token_.number;
        if (one.high < one.low) fault("expected a range from the smaller to the larger number");
        advance();
      }
      return one;
    }
    if (is_negative || (token_.kind != TokenKind::name && token_.kind != TokenKind::quoted)) {
      fault("expected a number, a word, or a list in braces such as {1, 4..6}");
    }
    one.word = token_.text;
    advance();
    return one;
  }

  void sum() {
    product();
    while (is("+") || is("-")) {
      const SelectionOp op = is("+") ? SelectionOp::add : SelectionOp::subtract;
      const std::size_t place = token_.place;
      advance();
      product();
      add(op, place);
    }
  }

  void product() {
    factor();
    while (is("*") || is("/")) {
      const SelectionOp op = is("*") ? SelectionOp::multiply : SelectionOp::divide;
      const std::size_t place = token_.place;
      advance();
      factor();
      add(op, place);
    }
  }

  void factor() {
    if (!is("-") && !is("+")) return primary();
    const Nested nested(*this);
    const bool is_minus = is("-");
    const std::size_t place = token_.place;
    advance();
    factor();
    if (is_minus) add(SelectionOp::negate, place);
  }

  void primary() {
    const std::size_t place = token_.place;
    if (token_.kind == TokenKind::number) {
      steps_.push_back({.op = SelectionOp::number, .offset = place, .number = token_.number, .word = token_.text});
      return advance();
    }
    if (token_.kind == TokenKind::name || token_.kind == TokenKind::quoted) return name_or_call();
    const Nested nested(*this);
    if (take("(")) {
      alternatives();
      return expect(")");
    }
    if (take("|")) {
      sum();
      expect("|");
      return add(SelectionOp::length, place);
    }
    fault("expected a number or the name of an attribute");
  }

  void name_or_call() {
    struct Function {
      std::string_view name;
      SelectionOp op;
      bool has_two;
    };
    constexpr std::array<Function, 5> kFunctions{{{"abs", SelectionOp::abs, false},
                                                  {"sqrt", SelectionOp::sqrt, false},
                                                  {"length", SelectionOp::length, false},
                                                  {"min", SelectionOp::min, true},
                                                  {"max", SelectionOp::max, true}}};
    const Token name = token_;
    const bool bare = name.kind == TokenKind::name;
    constexpr std::array<std::string_view, 4> kReserved{"and", "or", "not", "in"};
    if (bare && std::ranges::find(kReserved, name.text) != kReserved.end()) {
      fault("expected a number or the name of an attribute");
    }
    advance();
    if (!bare || !is("(")) return add_name(name);
    const auto* const function = std::ranges::find(kFunctions, name.text, &Function::name);
    if (function == kFunctions.end()) {
      throw Fault{name.place, fmt::format("expected one of the functions abs, sqrt, length, min and max, found '{}'",
                                          printable(name.text, 40))};
    }
    const Nested nested(*this);
    advance();
    sum();
    if (function->has_two) {
      expect(",");
      sum();
    }
    expect(")");
    add(function->op, name.place);
  }

  void add_name(const Token& name) {
    SelectionStep step{
        .op = SelectionOp::name, .offset = name.place, .word = name.text, .bare = name.kind == TokenKind::name};
    if (take("[")) {
      const bool is_index = token_.kind == TokenKind::number && token_.text.size() < 5 &&
                            token_.text.find_first_not_of("0123456789") == std::string::npos;
      if (!is_index) fault("expected the number of a component, counted from 0");
      step.component = static_cast<std::size_t>(token_.number);
      advance();
      expect("]");
    } else if (take(".")) {
      constexpr std::string_view kAxes = "xyz";
      const std::size_t axis = token_.text.size() == 1 ? kAxes.find(token_.text) : std::string_view::npos;
      if (token_.kind != TokenKind::name || axis == std::string_view::npos) {
        fault("expected one of the components x, y and z");
      }
      step.component = axis;
      advance();
    }
    if (step.component) step.spelled = name.text + std::string(text_.substr(name.end, end_ - name.end));
    steps_.push_back(std::move(step));
  }

  std::string_view text_;
  Lexer lexer_;
  Token token_;
  std::size_t end_ = 0;  // of the last token taken
  int depth_ = 0;
  std::vector<SelectionStep> steps_;
};

}  // namespace

Result<SelectionExpression> SelectionExpression::parse(std::string_view text) {
  if (text.size() > kMaxSelectionBytes) {
    return fail(ErrorCode::usage,
                fmt::format("expected a condition of at most {} bytes, found {}", kMaxSelectionBytes, text.size()));
  }
  SelectionExpression expression;
  expression.text_ = text;
  try {
    expression.steps_ = Parser(expression.text_).whole();
  } catch (const Fault& found) {
    return fail(ErrorCode::usage, found.message, expression.mark(found.place));
  }
  return expression;
}

std::vector<SelectionName> SelectionExpression::names() const {
  std::vector<SelectionName> names;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const SelectionStep& step = steps_[i];
    if (step.op != SelectionOp::name || axis_of(step)) continue;
    const SelectionOp next = i + 1 < steps_.size() ? steps_[i + 1].op : SelectionOp::both;
    const bool can_be_word = i > 0 && !step.component && (next == SelectionOp::equal || next == SelectionOp::not_equal);
    names.push_back({meanings_of(step), !can_be_word, mark(step.offset)});
  }
  return names;
}

std::string SelectionExpression::mark(std::size_t place) const {
  constexpr std::size_t kBefore = 60;
  constexpr std::size_t kAfter = 30;
  const auto starts_character = [&](std::size_t at) {
    return at >= text_.size() || (static_cast<unsigned char>(text_[at]) & 0xC0U) != 0x80U;
  };
  place = std::min(place, text_.size());
  std::size_t first = place > kBefore ? place - kBefore : 0;
  while (!starts_character(first)) ++first;
  std::size_t last = std::min(text_.size(), place + kAfter);
  while (!starts_character(last)) ++last;
  const std::string before = (first > 0 ? "..." : "") + printable(std::string_view(text_).substr(first, place - first));
  const std::string after = printable(std::string_view(text_).substr(place, last - place));
  const auto columns =
      std::ranges::count_if(before, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; });
  return fmt::format("look at this place:\n    {}{}{}\n    {}^", before, after, last < text_.size() ? "..." : "",
                     std::string(static_cast<std::size_t>(columns), ' '));
}

std::vector<std::string> meanings_of(const SelectionStep& name) {
  std::vector<std::string> names;
  if (name.component) names.push_back(name.spelled);  // a column may be called c_stress[1]
  names.push_back(name.word);
  const bool is_species = std::ranges::find(kSpeciesNames, name.word) != kSpeciesNames.end();
  for (const std::string_view other : kSpeciesNames) {
    if (is_species && name.bare && other != name.word) names.emplace_back(other);
  }
  return names;
}

std::optional<std::size_t> axis_of(const SelectionStep& name) {
  constexpr std::string_view kAxes = "xyz";
  if (!name.bare || name.component || name.word.size() != 1) return std::nullopt;
  const std::size_t axis = kAxes.find(name.word);
  return axis == std::string_view::npos ? std::nullopt : std::optional(axis);
}

std::string word_in_selection(std::string_view word) {
  constexpr std::string_view kQuotes = "'\"`";
  const std::size_t usable = kQuotes.find_first_not_of(word);
  return fmt::format("{0}{1}{0}", kQuotes[usable == std::string_view::npos ? 0 : usable], word);
}

}  // namespace isoextract::points
