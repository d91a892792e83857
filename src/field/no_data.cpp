#include "field/no_data.hpp"

#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::field {
namespace {

constexpr std::size_t kSamplesPerTask = std::size_t{1} << 16;

// A type that has NaN and represents every value of T.
template <class T>
using WithNan = std::conditional_t<
    is_floating_sample<T>, T,
    std::conditional_t<std::is_same_v<T, std::uint32_t> || std::is_same_v<T, std::int32_t>, double, float>>;

template <class T>
class NoDataTest {
 public:
  NoDataTest(const ValueScale& scale, double value) : scale_(scale) {
    if (scale.is_identity()) {
      stored_ = as_stored(value);
    } else {
      scaled_ = static_cast<float>(value);
    }
  }

  [[nodiscard]] bool operator()(T stored) const {
    if (scaled_) return static_cast<float>(scale_(static_cast<double>(stored))) == *scaled_;
    return stored_ && stored == *stored_;
  }

 private:
  // Returns nothing if no sample can have the value.
  static std::optional<T> as_stored(double value) {
    if constexpr (is_floating_sample<T>) {
      using Rounded = std::conditional_t<std::is_same_v<T, double>, double, float>;
      return static_cast<T>(static_cast<Rounded>(value));
    } else {
      const bool fits = value >= std::numeric_limits<T>::min() && value <= std::numeric_limits<T>::max();
      return fits && value == std::floor(value) ? std::optional<T>(static_cast<T>(value)) : std::nullopt;
    }
  }

  ValueScale scale_;
  std::optional<T> stored_;
  std::optional<float> scaled_;
};

template <class T>
Result<void> mark(ScalarField& field, const DenseSamples& samples, double value, const Context& context) {
  const NoDataTest<T> is_no_data(field.scale, value);
  const T* const from = static_cast<const T*>(samples.data);
  const std::size_t all = samples.count();
  std::atomic<std::uint64_t> found{0};
  for_each_range(all, kSamplesPerTask, [&](std::size_t begin, std::size_t end) {
    std::uint64_t count = 0;
    for (std::size_t i = begin; i < end; ++i) count += is_no_data(from[i]) ? 1 : 0;
    found += count;
  });
  if (found == 0) {
    field.notes.push_back({NoteId::no_data, fmt::format("no sample has the no-data value {}", value)});
    return {};
  }
  using Marked = WithNan<T>;
  auto made = TRY(make_reserved_buffer<Marked>(samples.count(), context,
                                               fmt::format("{}: the samples with NaN for no data", field.source)));
  Marked* const to = made->values.data();
  for_each_range(all, kSamplesPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      to[i] = is_no_data(from[i]) ? std::numeric_limits<Marked>::quiet_NaN() : static_cast<Marked>(from[i]);
    }
  });
  if (samples.lost()) {
    return fail(ErrorCode::input, field.source + ": the file became shorter, or reading it failed, during the run");
  }
  field.notes.push_back({NoteId::no_data, fmt::format("{} of {} samples have the no-data value {} and become NaN",
                                                      found.load(), samples.count(), value)});
  DenseSamples marked;
  marked.type = sample_type_of<Marked>();
  marked.dims = samples.dims;
  marked.data = to;
  marked.owner = std::move(made);
  field.samples = std::move(marked);
  return {};
}

}  // namespace

Result<void> mark_no_data(ScalarField& field, double value, const Context& context) {
  const auto* dense = std::get_if<DenseSamples>(&field.samples);
  if (dense == nullptr) {
    return fail(ErrorCode::usage,
                field.source +
                    ": a no-data value applies to dense grids only; this grid is sparse and has the background "
                    "value where it stores no voxels");
  }
  const DenseSamples samples = *dense;
  return visit_sample_type(samples.type,
                           [&]<class T>(std::type_identity<T>) { return mark<T>(field, samples, value, context); });
}

}  // namespace isoextract::field
