// Lists the methods of the method table, for suites that run over all methods or over those with a trait. A new row of
// the table joins these suites automatically.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"

namespace isoextract::test {

// Returns the method's name with underscores for characters that test names must not have.
inline std::string identifier_of(extract::Method method) {
  std::string name(word_of(method));
  std::ranges::replace(name, '-', '_');
  return name;
}
// Names the tests of INSTANTIATE_TEST_SUITE_P over methods.
inline std::string method_name(const testing::TestParamInfo<extract::Method>& parameter) {
  return identifier_of(parameter.param);
}

inline const extract::MethodTraits& traits_of(extract::Method method) { return extract::method_info(method).traits; }

template <class Condition>
std::vector<extract::Method> methods_where(const Condition& holds) {
  std::vector<extract::Method> methods;
  for (const extract::MethodInfo& info : extract::kMethods) {
    if (holds(info)) methods.push_back(info.method);
  }
  return methods;
}

inline std::vector<extract::Method> all_methods() {
  return methods_where([](const extract::MethodInfo&) { return true; });
}
// Returns the methods with a trait, for example methods_with(&MethodTraits::gradient_normals).
inline std::vector<extract::Method> methods_with(bool extract::MethodTraits::*trait) {
  return methods_where([&](const extract::MethodInfo& info) { return info.traits.*trait; });
}
inline std::vector<extract::Method> methods_without(bool extract::MethodTraits::*trait) {
  return methods_where([&](const extract::MethodInfo& info) { return !(info.traits.*trait); });
}
// Returns the methods that draw each cell by a table of cases (cell_tables.hpp).
inline std::vector<extract::Method> cell_methods() {
  return methods_where([](const extract::MethodInfo& info) { return info.run_on_cpu == extract::extract_by_cells; });
}

inline extract::ExtractOptions options_of(extract::Method method, double iso, bool cap = false) {
  extract::ExtractOptions options;
  options.method = method;
  options.iso = iso;
  options.cap = cap;
  return options;
}

// Returns how far a surface that is closed at the data boundary reaches beyond the outermost samples, in grid steps.
// Methods that always close it treat samples as boxes; otherwise the cap is at the outermost samples.
inline double reach_beyond_samples(extract::Method method) { return traits_of(method).always_closed ? 0.5 : 0; }

}  // namespace isoextract::test
