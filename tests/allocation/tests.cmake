# Conversions in which one allocation fails, one run for each allocation.
add_executable(test_allocation allocation/allocation_test.cpp allocation/failing_allocations.cpp)
target_link_libraries(test_allocation PRIVATE isoextract_convert isoextract_options GTest::gtest_main ${CMAKE_DL_LIBS})
target_include_directories(test_allocation PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_definitions(test_allocation PRIVATE ISOEXTRACT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_options(test_allocation PRIVATE LINKER:--wrap=aligned_alloc,--wrap=mmap)
gtest_discover_tests(test_allocation DISCOVERY_MODE PRE_TEST TEST_PREFIX allocation.)
