isoextract_unit_test(bench
  benchmark_test.cpp method_traits_test.cpp stability_test.cpp reference_size_test.cpp)
