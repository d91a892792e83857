#include "field/percentiles.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <functional>
#include <type_traits>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "base/ascii.hpp"
#include "field/detail/value_tally.hpp"

namespace isoextract::field {
namespace {

constexpr int kDigitBits = 16;
constexpr std::size_t kDigitValues = std::size_t{1} << kDigitBits;
constexpr std::size_t kPercentilesPerPass = 8;  // limits the memory of the counts

// Maps numbers of T to unsigned integers of the same size and order.
template <class T>
class OrderedKeys {
 public:
  using Key = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;

  [[nodiscard]] static Key of(T value) {
    const auto bits = std::bit_cast<Key>(value);
    if constexpr (std::is_floating_point_v<T>) return (bits & kSign) != 0 ? ~bits : bits | kSign;
    return std::is_signed_v<T> ? bits ^ kSign : bits;
  }

  [[nodiscard]] static T value(Key key) {
    if constexpr (std::is_floating_point_v<T>) return std::bit_cast<T>((key & kSign) != 0 ? key & ~kSign : ~key);
    return std::bit_cast<T>(std::is_signed_v<T> ? key ^ kSign : key);
  }

 private:
  static constexpr Key kSign = Key{1} << (8 * sizeof(Key) - 1);
};

// Finds the samples of the given ascending ranks, 16 bits of their keys per pass, in the order of the scaled values.
// Each pass counts the next bits of the samples whose leading bits are the ones found so far.
template <class T>
std::vector<double> samples_of_ranks(const ScalarField& field, std::vector<std::uint64_t> ranks, Progress* progress) {
  using Key = typename OrderedKeys<T>::Key;
  const ValueScale scale = field.scale;
  const auto key_of = [falling = scale.slope < 0](T stored) {
    const Key key = OrderedKeys<T>::of(stored);
    return falling ? static_cast<Key>(~key) : key;
  };
  std::vector<Key> found(ranks.size());  // the leading bits so far
  for (int shift = 8 * static_cast<int>(sizeof(Key)) - kDigitBits; shift >= 0; shift -= kDigitBits) {
    const bool first = shift + kDigitBits == 8 * static_cast<int>(sizeof(Key));
    std::vector<Key> prefixes;  // without duplicates
    for (const Key prefix : found) {
      if (prefixes.empty() || prefixes.back() != prefix) prefixes.push_back(prefix);
    }
    const auto add = [&](std::vector<std::uint64_t>& counts, T stored, std::uint64_t times) {
      if (!std::isfinite(scale(static_cast<double>(stored)))) return;
      const Key key = key_of(stored);
      const Key before = first ? 0 : key >> (shift + kDigitBits) % (8 * sizeof(Key));
      for (std::size_t slot = 0; slot < prefixes.size(); ++slot) {
        if (prefixes[slot] == before) counts[slot * kDigitValues + (key >> shift) % kDigitValues] += times;
      }
    };
    std::vector<std::uint64_t> counts = count_samples<T>(
        field, prefixes.size() * kDigitValues,
        [&](std::vector<std::uint64_t>& part, std::span<const T> values) {
          for (const T stored : values) add(part, stored, 1);
        },
        progress);
    for_each_tile(field, [&](double stored, std::uint64_t voxels) { add(counts, static_cast<T>(stored), voxels); });
    for (std::size_t p = 0; p < ranks.size(); ++p) {
      const auto slot = static_cast<std::size_t>(std::ranges::find(prefixes, found[p]) - prefixes.begin());
      // The samples may have changed since the count, if another program writes to the file. The loop must end anyway.
      Key digit = 0;
      for (; digit + 1 < kDigitValues && ranks[p] >= counts[slot * kDigitValues + digit]; ++digit) {
        ranks[p] -= counts[slot * kDigitValues + digit];
      }
      found[p] = (first ? 0 : found[p] << kDigitBits) | digit;
    }
  }
  std::vector<double> samples;
  for (const Key key : found) {
    const Key stored = scale.slope < 0 ? static_cast<Key>(~key) : key;
    samples.push_back(scale(static_cast<double>(OrderedKeys<T>::value(stored))) + 0.0);  // -0 is 0
  }
  return samples;
}

template <class T>
std::uint64_t count_finite(const ScalarField& field, Progress* progress) {
  const auto is_finite = [scale = field.scale](double stored) { return std::isfinite(scale(stored)); };
  std::uint64_t count = reduce_samples<T>(
      field, std::uint64_t{0},
      [&](std::uint64_t& part, std::span<const T> values) {
        part += static_cast<std::uint64_t>(
            std::ranges::count_if(values, [&](T stored) { return is_finite(static_cast<double>(stored)); }));
      },
      std::plus<>{}, progress);
  for_each_tile(field, [&](double stored, std::uint64_t voxels) { count += is_finite(stored) ? voxels : 0; });
  return count;
}

}  // namespace

std::optional<Percent> Percent::parse(std::string_view text) {
  const std::size_t point = std::min(text.find('.'), text.size());
  std::string digits(text.substr(0, point));
  std::string decimals(text.substr(std::min(point + 1, text.size())));
  if (digits.empty() || (point < text.size() && decimals.empty()) || decimals.size() > kDecimals) return std::nullopt;
  decimals.resize(kDecimals, '0');
  digits += decimals;
  std::uint64_t parts = 0;
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), parts);
  if (!std::ranges::all_of(digits, is_digit) || status != std::errc() || parts > 100U * std::uint64_t{kPart}) {
    return std::nullopt;
  }
  Percent percent;
  percent.parts_ = static_cast<std::uint32_t>(parts);
  return percent;
}

std::string Percent::text() const {
  std::string text = fmt::format("{}.{:06}", parts_ / kPart, parts_ % kPart);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::uint64_t Percent::rank_among(std::uint64_t samples) const {
  constexpr std::uint64_t kWhole = 100U * std::uint64_t{kPart};
  const std::uint64_t rest = samples % kWhole * parts_;
  const std::uint64_t share = samples / kWhole * parts_ + (rest + kWhole - 1) / kWhole;
  return std::max<std::uint64_t>(share, 1) - 1;
}

std::vector<double> percentiles_of(std::span<const CountedValue> values, std::uint64_t samples,
                                   std::span<const Percent> percents) {
  std::vector<double> percentiles;
  auto value = values.begin();
  std::uint64_t upto = value->second;
  for (const Percent percent : percents) {
    const std::uint64_t rank = percent.rank_among(samples);
    while (upto <= rank) upto += (++value)->second;
    percentiles.push_back(value->first + 0.0);  // -0 is 0
  }
  return percentiles;
}

std::vector<double> percentiles_of(const ScalarField& field, std::uint64_t samples, std::span<const Percent> percents,
                                   Progress* progress) {
  std::vector<std::uint64_t> ranks;
  for (const Percent percent : percents) ranks.push_back(percent.rank_among(samples));
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    if constexpr (kIsCountable<T>) {
      return std::vector<double>();
    } else {
      return samples_of_ranks<T>(field, std::move(ranks), progress);
    }
  });
}

std::optional<std::vector<double>> measure_percentiles(const ScalarField& field, std::span<const Percent> percents,
                                                       Progress* progress) {
  std::vector<Percent> rising(percents.begin(), percents.end());
  std::ranges::sort(rising);
  rising.erase(std::unique(rising.begin(), rising.end()), rising.end());
  std::uint64_t samples = 0;
  const std::vector<double> found = visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    std::vector<double> all(rising.size());
    if constexpr (kIsCountable<T>) {
      std::vector<CountedValue> values = Tally<T>(field, progress).values(field.scale);
      keep_finite_sorted(values);
      for (const auto& [value, count] : values) samples += count;
      if (samples > 0) all = percentiles_of(values, samples, rising);
    } else {
      samples = count_finite<T>(field, progress);
      for (std::size_t p = 0; samples > 0 && p < rising.size(); p += kPercentilesPerPass) {
        const std::span<const Percent> some(rising.data() + p, std::min(kPercentilesPerPass, rising.size() - p));
        std::ranges::copy(percentiles_of(field, samples, some, progress), all.begin() + static_cast<std::ptrdiff_t>(p));
      }
    }
    return all;
  });
  if (samples == 0) return std::nullopt;
  std::vector<double> percentiles;
  for (const Percent percent : percents) {
    percentiles.push_back(found[static_cast<std::size_t>(std::ranges::lower_bound(rising, percent) - rising.begin())]);
  }
  return percentiles;
}

std::uint64_t statistics_bytes(std::size_t percents) {
  const auto threads = static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
  const std::uint64_t counts =
      std::clamp<std::uint64_t>(percents, 1, kPercentilesPerPass) * kDigitValues * sizeof(std::uint64_t);
  return (threads + 1) * counts + kDigitValues * sizeof(CountedValue);
}

}  // namespace isoextract::field
