#include "mesh_io/write/json_lists.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace isoextract::mesh_io {
namespace {

std::vector<std::string> texts_of(const std::vector<JsonLists::Member>& members) {
  std::vector<std::string> texts;
  for (const JsonLists::Member& member : members) {
    texts.push_back(member.name + " " + std::to_string(static_cast<int>(member.kind)) + " " + member.text);
  }
  return texts;
}

TEST(JsonLists, SplitsTextAsItSplitsTheParsedDocument) {
  const nlohmann::json document = {
      {"accessors", {{{"max", {1.5, -2, 3e-9}}, {"min", nlohmann::json::array()}}, nlohmann::json::object()}},
      {"asset", {{"extras", {{"of", "a]b}c,d:e"}}}, {"version", "2.0"}}},
      {"empty", nlohmann::json::array()},
      {"extensionsUsed", {"A", "B,\"]\\", "\xC2\x9B"}},
      {"names", {{{"na[me", "quote \" and \\\" end\\"}}, nullptr, {1, {2, {3}}}}},
      {"scene", 0},
      {"text", "x,y"},
      {"yes", true}};
  EXPECT_EQ(texts_of(JsonLists::members_of_text(document.dump())), texts_of(JsonLists::members_of(document)));
  EXPECT_TRUE(JsonLists::members_of_text("{}").empty());
}

TEST(JsonLists, AppendsEntriesAndKeepsRepeatedStringsOnce) {
  JsonLists lists;
  lists.add(nlohmann::json{{"nodes", {1, 2}}, {"used", {"A"}}, {"asset", "first"}});
  lists.add(JsonLists::members_of_text(R"({"asset":"second","nodes":[3],"used":["A","B"]})"));
  EXPECT_EQ(lists.take(JsonLists::MemberOrder::by_name), R"({"asset":"first","nodes":[1,2,3],"used":["A","B"]})");
  EXPECT_TRUE(lists.empty());
}

}  // namespace
}  // namespace isoextract::mesh_io
