// Parallel loops. Only parallel.cpp instantiates TBB's loops, so the compiler does not instantiate them for each body
// and sample type. A grain must be at least 1.
#pragma once

#include <concepts>
#include <cstddef>
#include <memory>
#include <utility>

namespace isoextract {

// Returns how many threads the calling thread's loops may use.
[[nodiscard]] int usable_threads();

namespace detail {

// A type-erased reference to a loop body. The caller keeps the body alive.
struct RangeBody {
  const void* body;
  void (*run)(const void* body, std::size_t begin, std::size_t end);

  template <class Body>
  static RangeBody of(const Body& body) {
    return {&body, [](const void* object, std::size_t begin, std::size_t end) {
              (*static_cast<const Body*>(object))(begin, end);
            }};
  }
};

void parallel_ranges(std::size_t count, std::size_t grain, RangeBody body);
void fixed_ranges(std::size_t count, std::size_t grain, RangeBody body);

// A type-erased partial result of reduce_ranges.
class Reduction {
 public:
  Reduction() = default;
  Reduction(const Reduction&) = delete;
  Reduction& operator=(const Reduction&) = delete;
  virtual ~Reduction() = default;

  // Returns a partial result that holds the identity.
  [[nodiscard]] virtual std::unique_ptr<Reduction> fresh() const = 0;
  virtual void run(std::size_t begin, std::size_t end) = 0;
  // Merges `later`, the partial result of the indices that follow.
  virtual void join(Reduction& later) = 0;
};

void reduce_ranges(std::size_t count, std::size_t grain, Reduction& all);

}  // namespace detail

// Calls body(begin, end) in parallel on ranges that cover [0, count). A range of at most `grain` indices is not split
// further. Rethrows the first exception of a body; the remaining ranges are then skipped, and loops inside other bodies
// stop halfway.
template <class Body>
void for_each_range(std::size_t count, std::size_t grain, const Body& body) {
  detail::parallel_ranges(count, grain, detail::RangeBody::of(body));
}

// Like for_each_range, but each range has at most `grain` indices, and the ranges depend on `count` and `grain` only.
template <class Body>
void for_each_fixed_range(std::size_t count, std::size_t grain, const Body& body) {
  detail::fixed_ranges(count, grain, detail::RangeBody::of(body));
}

// Calls body(index) in parallel for each index in [0, count).
template <std::integral Index, class Body>
void for_each_index(Index count, const Body& body, std::size_t grain = 1) {
  for_each_range(count > 0 ? static_cast<std::size_t>(count) : 0, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) body(static_cast<Index>(i));
  });
}

// Returns the join of body(begin, end, partial) over ranges of at most `grain` indices that cover [0, count). `partial`
// is `identity` at first; join(earlier, later) merges neighbors. The ranges and the order of joins depend on `count`
// and `grain` only. Throws the first exception of a body, a join or a copy of `identity`, once all bodies have ended.
template <class Partial, class Body, class Join>
[[nodiscard]] Partial reduce_ranges(std::size_t count, std::size_t grain, const Partial& identity, const Body& body,
                                    const Join& join) {
  class Typed final : public detail::Reduction {
   public:
    Typed(const Partial& identity, const Body& body, const Join& join)
        : value(identity), identity_(identity), body_(body), join_(join) {}
    [[nodiscard]] std::unique_ptr<Reduction> fresh() const override {
      return std::make_unique<Typed>(identity_, body_, join_);
    }
    void run(std::size_t begin, std::size_t end) override { value = body_(begin, end, std::move(value)); }
    void join(Reduction& later) override {
      value = join_(std::move(value), std::move(static_cast<Typed&>(later).value));
    }

    Partial value;

   private:
    const Partial& identity_;
    const Body& body_;
    const Join& join_;
  };
  Typed all(identity, body, join);
  detail::reduce_ranges(count, grain, all);
  return std::move(all.value);
}

}  // namespace isoextract
