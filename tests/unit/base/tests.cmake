isoextract_unit_test(base attribute_kind_test.cpp buffer_test.cpp checked_test.cpp hash_test.cpp byte_size_test.cpp
  memory_budget_test.cpp pages_test.cpp printable_test.cpp)
