// The methods of the method table, for suites that run over all of them or over those with a trait: a new row of the
// table is in these suites by itself.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"

namespace isoextract::test {

// The method's name with underscores for what the name of a test must not have.
inline std::string identifier_of(extract::Method method) {
  std::string name(word_of(method));
  std::ranges::replace(name, '-', '_');
  return name;
}
// For INSTANTIATE_TEST_SUITE_P over methods.
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
// methods_with(&MethodTraits::gradient_normals)
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

// How far a surface that is closed at the border of the data reaches beyond the outermost samples, in steps of the
// grid: where it always is closed, samples are boxes; else the cap stands at the samples.
inline double reach_beyond_samples(extract::Method method) { return traits_of(method).always_closed ? 0.5 : 0; }

}  // namespace isoextract::test
