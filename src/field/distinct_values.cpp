#include "field/distinct_values.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "field/detail/sample_passes.hpp"

namespace isoextract::field {
namespace {

using Values = std::vector<double>;

void sort_unique(Values& values) {
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

Values united(const Values& a, const Values& b) {
  Values all;
  std::ranges::set_union(a, b, std::back_inserter(all));
  return all;
}

template <class T>
void add_values(Values& known, std::span<const T> samples) {
  Values found;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto value = static_cast<double>(samples[i]);
    // Equal samples are mostly adjacent.
    if (std::isfinite(value) && (found.empty() || found.back() != value)) found.push_back(value);
  }
  sort_unique(found);
  known = known.empty() ? std::move(found) : united(known, found);
}

}  // namespace

std::vector<double> distinct_values(const ScalarField& field, Progress* progress) {
  Values values = visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    return reduce_samples<T>(
        field, Values(), [](Values& known, std::span<const T> samples) { add_values(known, samples); }, united,
        progress);
  });
  for_each_tile(field, [&](double value, std::uint64_t) {
    if (std::isfinite(value)) values.push_back(value);
  });
  sort_unique(values);
  return values;
}

}  // namespace isoextract::field
