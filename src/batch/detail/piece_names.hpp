// Output names with {piece}, whose numbers are known only when a surface exists: detects names that could become
// equal. Used only by output_names.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::batch {

class PieceNames {
 public:
  // Adds a name with convert::kPiecePlaceholder, of the output `owner`, and returns nullopt. If body numbers could make
  // the name equal to an earlier one, returns the owner of that one instead. Compares only the digits in the keys of
  // Group::owners, so it may report names that never collide, but misses none.
  [[nodiscard]] std::optional<std::size_t> add(std::string_view name, std::size_t owner);

  // Returns the owner of a name that the number of some body could make equal to `file`, or nullopt.
  [[nodiscard]] std::optional<std::size_t> find_collision(std::string_view file) const;

 private:
  struct Group {
    std::vector<bool> numbered;  // which runs of digits contain {piece}; the same for all names of the group
    std::size_t owner = 0;       // of the group's first name
    // Keys: digits of the runs without {piece}, then the digits before the first {piece}. No key is a prefix of
    // another.
    std::map<std::string, std::size_t> owners;
  };
  std::map<std::string, Group> groups_;  // by the text between the runs
};

}  // namespace isoextract::batch
