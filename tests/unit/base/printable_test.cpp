#include "base/printable.hpp"
#include "base/printable_json.hpp"

#include <array>
#include <utility>

#include <gtest/gtest.h>

namespace isoextract {
namespace {

using namespace std::string_view_literals;

TEST(Printable, KeepsPrintableUtf8) {
  for (const std::string_view text :
       {""sv, "density"sv, "a name, with 'quotes' and \\ and [1]"sv, "fläche"sv, "flèche"sv, "密度"sv, "\U0001f4a8"sv,
        "\u00a0 \u07ff \u0800 \ud7ff \ue000 \U00010000 \U0010ffff"sv}) {
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Printable, EscapesCharactersThatControlTerminal) {
  const std::array<std::pair<std::string_view, std::string_view>, 9> cases{
      {{"\x1b[31mred\x1b[0m"sv, R"(\x1b[31mred\x1b[0m)"},
       {"two\nlines\r\n"sv, R"(two\nlines\r\n)"},
       {"a\tb"sv, R"(a\tb)"},
       {"a\0b"sv, R"(a\x00b)"},
       {"\x07\x7f"sv, R"(\x07\x7f)"},
       {"\u009b31m\u0085"sv, R"(\u009b31m\u0085)"},
       {"\u2028\u2029"sv, R"(\u2028\u2029)"},
       {"gpj.\u202egnp"sv, R"(gpj.\u202egnp)"},
       {"\u2066\u2069"sv, R"(\u2066\u2069)"}}};
  for (const auto& [text, shown] : cases) {
    EXPECT_EQ(printable(text), shown);
    EXPECT_EQ(printable(printable(text)), shown) << "twice is as once";
  }
}

TEST(Printable, EscapesInvalidUtf8) {
  const std::array<std::pair<std::string_view, std::string_view>, 9> cases{{
      {"fl\xe8"
       "che"sv,
       R"(fl\xe8che)"},
      {"\x80\xbf"sv, R"(\x80\xbf)"},
      {"\xc0\xaf"sv, R"(\xc0\xaf)"},                  // an overlong '/'
      {"\xe0\x9f\xbf"sv, R"(\xe0\x9f\xbf)"},          // overlong
      {"\xf0\x8f\xbf\xbf"sv, R"(\xf0\x8f\xbf\xbf)"},  // overlong
      {"\xed\xa0\x80"sv, R"(\xed\xa0\x80)"},          // half of a pair
      {"\xf4\x90\x80\x80"sv, R"(\xf4\x90\x80\x80)"},  // beyond the last
      {"\xff\xfe"sv, R"(\xff\xfe)"},
      {"\xc3"sv, R"(\xc3)"},  // cut off
  }};
  for (const auto& [text, shown] : cases) EXPECT_EQ(printable(text), shown);
  EXPECT_EQ(printable("\xe5\xaf"sv
                      "x"),
            R"(\xe5\xafx)");
}

TEST(Printable, CutsLongTextBetweenCharacters) {
  EXPECT_EQ(printable("abcdef", 6), "abcdef");
  EXPECT_EQ(printable("abcdef", 5), "abcde...");
  EXPECT_EQ(printable("abc\u00e4f", 4), "abc...");
  EXPECT_EQ(printable("abc\u00e4f", 5), "abc\u00e4...");
  EXPECT_EQ(printable("\n\n\n", 2), R"(\n\n...)");
  const std::array bytes{std::byte{0x89}, std::byte{'P'}, std::byte{'N'}, std::byte{'G'}};
  EXPECT_EQ(printable(bytes, 3), R"(\x89PN...)");
}

TEST(Printable, JsonKeepsItsStrings) {
  const std::pair<std::string_view, std::string_view> cases[] = {
      {"{\"a\": \"\\n b\"}\n", "{\"a\": \"\\n b\"}\n"},
      {"[\"\x7f\"]", "[\"\\u007f\"]"},
      {"[\"\xc2\x9b\x7f\xc2\xa0\xe2\x80\xae\xe2\x82\xac\xe2\x81\xa7\"]",
       "[\"\\u009b\\u007f\xc2\xa0\\u202e\xe2\x82\xac\\u2067\"]"},
      {"[\"\xe2\x80\xa8\xe2\x80\xa9\"]", "[\"\\u2028\\u2029\"]"},
      {"[\"\xc2", "[\"\xc2"},
      {"", ""},
  };
  for (const auto& [json, shown] : cases) EXPECT_EQ(printable_json(std::string(json)), shown);
}

}  // namespace
}  // namespace isoextract
