// Collects the lists of a large JSON document as text, from many small documents. Text takes a few hundred bytes per
// frame, a tree of JSON values several times as much.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace isoextract::mesh_io {

class JsonLists {
 public:
  // The members of a document as text, with the entries of lists apart.
  struct Member {
    enum class Kind : std::uint8_t { whole, entry, text_entry };

    std::string name;
    std::string text;
    Kind kind;
  };

  [[nodiscard]] static std::vector<Member> members_of(const nlohmann::json& document);
  // Takes the text of a document, an object without spaces between its parts. Several times as fast as to parse the
  // text and to write it again.
  [[nodiscard]] static std::vector<Member> members_of_text(std::string_view text);

  // Appends each list of the document to the list of the same name. Repeated strings (names of extensions) are kept
  // once. Members that are not lists keep their first value.
  void add(const nlohmann::json& document) { add(members_of(document)); }
  void add(std::vector<Member> members);
  // Appends an entry, which is JSON text, and returns its number.
  std::size_t add(const std::string& list, std::string_view entry);

  // Returns the size of the whole text, or up to a few bytes per list more.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  enum class MemberOrder : std::uint8_t { others_first, by_name };

  // Returns the whole text and clears all lists.
  [[nodiscard]] std::string take(MemberOrder order = MemberOrder::others_first);

  [[nodiscard]] bool empty() const { return lists_.empty() && others_.empty(); }

 private:
  struct List {
    std::string text;  // without the brackets
    std::size_t count = 0;
  };

  std::map<std::string, List> lists_;
  std::map<std::string, std::string> others_;
  std::uint64_t bytes_ = 2;  // the braces
};

}  // namespace isoextract::mesh_io
