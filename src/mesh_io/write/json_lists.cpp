#include "mesh_io/write/json_lists.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/printable_json.hpp"

namespace isoextract::mesh_io {
namespace {

// Returns the bytes of "name":[] and a comma.
std::uint64_t bytes_around(const std::string& name) { return name.size() + 6; }

// Returns the end of the JSON value that begins at `at`, in a document without spaces between its parts.
std::size_t end_of_value(std::string_view text, std::size_t at) {
  std::size_t depth = 0;
  bool in_string = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (in_string) {
      if (c == '\\') ++at;
      in_string = c != '"';
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ',' || c == ':' || c == ']' || c == '}') {
      if (depth == 0) return at;
      if (c == ']' || c == '}') --depth;
    }
  }
  return at;
}

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

std::vector<JsonLists::Member> JsonLists::members_of_text(std::string_view text) {
  std::vector<Member> members;
  std::size_t at = 1;  // after the brace
  while (at < text.size() && text[at] == '"') {
    const std::size_t colon = end_of_value(text, at);
    const std::string name(text.substr(at + 1, colon - at - 2));
    at = colon + 1;
    const bool is_list = text[at] == '[';
    const std::size_t end = end_of_value(text, at);
    if (is_list) ++at;
    while (at < end && text[at] != ']') {
      const std::size_t entry_end = is_list ? end_of_value(text, at) : end;
      const Member::Kind kind = !is_list          ? Member::Kind::whole
                                : text[at] == '"' ? Member::Kind::text_entry
                                                  : Member::Kind::entry;
      std::string value(text.substr(at, entry_end - at));
      members.push_back({name, printable_json(std::move(value)), kind});
      at = entry_end;
      if (is_list && text[at] == ',') ++at;
    }
    at = end + 1;  // after the comma, or the closing brace
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
