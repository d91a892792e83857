# For scripts/compare_topology.py; not a test by itself.
add_executable(write_random_fields EXCLUDE_FROM_ALL topology/write_random_fields.cpp)
target_link_libraries(write_random_fields PRIVATE isoextract_extract isoextract_options)
target_include_directories(write_random_fields PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
