isoextract_unit_test(field demo_field_test.cpp statistics_test.cpp)
