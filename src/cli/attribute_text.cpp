#include "cli/attribute_text.hpp"

#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/counted.hpp"
#include "base/printable.hpp"
#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

std::string match_text(const accuracy::AttributeMatch& match, bool same_vertices) {
  const auto& [first, second] = match.components;
  if (first != second) return fmt::format("{} and {} components", first, second);
  if (!match.difference) {
    return same_vertices ? "in both; not compared: glTF stores linear light, other formats store sRGB"
                         : "in both; not compared, because the vertices differ";
  }
  const accuracy::AttributeMatch::Difference& difference = *match.difference;
  std::string text = difference.largest == 0 ? "the same values"
                                             : fmt::format("largest difference {:.6g}, at vertex {}; mean {:.6g}",
                                                           difference.largest, difference.vertex, difference.mean);
  if (difference.not_finite > 0)
    text +=
        fmt::format("; {} with a finite value in only one mesh", counted(difference.not_finite, "vertex", "vertices"));
  return text;
}

}  // namespace

void add_attributes(NamedLines& lines, const accuracy::AttributeMatches& matches) {
  const auto& [first, second] = matches.only;
  if (matches.both.empty() && first.empty() && second.empty()) return;
  lines.plain("");
  lines.plain("attributes of the vertices");
  for (const accuracy::AttributeMatch& match : matches.both) {
    lines.add(printable(match.name), match_text(match, matches.same_vertices));
  }
  for (const std::string& name : first) lines.add(printable(name), "only in the first mesh");
  for (const std::string& name : second) lines.add(printable(name), "only in the second mesh");
}

convert::Json attributes_json(const accuracy::AttributeMatches& matches) {
  convert::Json both = convert::Json::array();
  for (const accuracy::AttributeMatch& match : matches.both) {
    convert::Json& json = both.emplace_back();
    json = {{"name", match.name}, {"components", match.components}, {"difference", nullptr}};
    if (!match.difference) continue;
    json["difference"] = {{"largest", match.difference->largest},
                          {"vertex", match.difference->vertex},
                          {"mean", match.difference->mean},
                          {"not_finite", match.difference->not_finite}};
  }
  return {{"same_vertices", matches.same_vertices},
          {"both", both},
          {"a_only", matches.only[0]},
          {"b_only", matches.only[1]}};
}

}  // namespace isoextract::cli
