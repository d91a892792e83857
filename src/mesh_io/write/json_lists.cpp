#include "mesh_io/write/json_lists.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/printable_json.hpp"

namespace isoextract::mesh_io {
namespace {

// Returns the bytes of "name":[] and a comma.
std::uint64_t bytes_around(const std::string& name) { return name.size() + 6; }

}  // namespace

std::vector<JsonLists::Member> JsonLists::members_of(const nlohmann::json& document) {
  std::vector<Member> members;
  for (const auto& [name, value] : document.items()) {
    if (!value.is_array()) {
      members.push_back({name, printable_json(value.dump()), Member::Kind::whole});
      continue;
    }
    for (const nlohmann::json& entry : value) {
      members.push_back(
          {name, printable_json(entry.dump()), entry.is_string() ? Member::Kind::text_entry : Member::Kind::entry});
    }
  }
  return members;
}

void JsonLists::add(std::vector<Member> members) {
  for (Member& member : members) {
    if (member.kind == Member::Kind::whole) {
      const auto [other, is_new] = others_.try_emplace(member.name);
      if (!is_new) continue;
      other->second = std::move(member.text);
      bytes_ += bytes_around(member.name) + other->second.size();
      continue;
    }
    const auto list = lists_.find(member.name);
    const bool is_there = member.kind == Member::Kind::text_entry && list != lists_.end() &&
                          list->second.text.find(member.text) != std::string::npos;
    if (!is_there) add(member.name, member.text);
  }
}

std::size_t JsonLists::add(const std::string& list, std::string_view entry) {
  const auto [found, is_new] = lists_.try_emplace(list);
  if (is_new) bytes_ += bytes_around(list);
  List& there = found->second;
  if (there.count > 0) there.text += ',';
  there.text += entry;
  bytes_ += entry.size() + 1;
  return there.count++;
}

std::string JsonLists::take(MemberOrder order) {
  std::string text = "{";
  text.reserve(bytes_);
  const auto begin = [&](const std::string& name) { text += fmt::format(R"({}"{}":)", text == "{" ? "" : ",", name); };
  auto other = others_.begin();
  const auto add_others = [&](const std::string* end) {
    for (; other != others_.end() && (end == nullptr || other->first < *end); ++other) {
      begin(other->first);
      text += other->second;
    }
  };
  if (order == MemberOrder::others_first) add_others(nullptr);
  for (auto& [name, list] : lists_) {
    add_others(&name);
    begin(name);
    text += '[';
    text += std::exchange(list.text, {});
    text += ']';
  }
  add_others(nullptr);
  text += '}';
  *this = {};
  return text;
}

}  // namespace isoextract::mesh_io
