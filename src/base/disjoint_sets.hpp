// Disjoint sets that threads join without locks: R. J. Anderson, H. Woll: Wait-free parallel algorithms for the
// union-find problem. STOC 1991. Roots are linked by number, not by rank, so that the root of a set is its lowest
// element for any order of the threads.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

namespace isoextract {

class DisjointSets {
 public:
  // `parents` holds the parent of each element, and must outlive the object; a root is its own parent. Elements that no
  // call joins may hold other numbers. With `alone`, only one thread may join sets, which avoids locked instructions.
  explicit DisjointSets(std::span<std::uint32_t> parents, bool alone = false) : parents_(parents), alone_(alone) {}

  // Joins the sets of two elements.
  void join(std::uint32_t a, std::uint32_t b) const {
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      if (replace(a, a, b)) return;  // a was still a root
    }
  }

  // Returns the lowest element known to be in the set of `element`. Shortens the path for later calls. While several
  // threads call it, one thread may overwrite a parent that another thread has set to the root, with an ancestor that
  // is no root.
  [[nodiscard]] std::uint32_t root(std::uint32_t element) const {
    std::uint32_t up = load(element);
    while (up != element) {
      const std::uint32_t next = load(up);
      // Another thread may have stored a parent nearer to the root; an older one is correct as well.
      if (next != up) store(element, next);
      element = up;
      up = next;
    }
    return element;
  }

  // Replaces the parent of an element if the parent still is `expected`; returns whether it was.
  [[nodiscard]] bool replace(std::uint32_t element, std::uint32_t expected, std::uint32_t parent) const {
    if (!alone_) {
      return std::atomic_ref(parents_[element]).compare_exchange_strong(expected, parent, std::memory_order_relaxed);
    }
    if (parents_[element] != expected) return false;
    parents_[element] = parent;
    return true;
  }

  [[nodiscard]] std::uint32_t load(std::uint32_t element) const {
    return std::atomic_ref(parents_[element]).load(std::memory_order_relaxed);
  }
  void store(std::uint32_t element, std::uint32_t parent) const {
    std::atomic_ref(parents_[element]).store(parent, std::memory_order_relaxed);
  }

 private:
  std::span<std::uint32_t> parents_;
  bool alone_;
};

}  // namespace isoextract
