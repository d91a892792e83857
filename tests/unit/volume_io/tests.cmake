include(${PROJECT_SOURCE_DIR}/cmake/OpenVDB.cmake)

# Together these files take the compiler very much longer than one by one.
set_target_properties(test_volume_io PROPERTIES UNITY_BUILD OFF)
target_sources(test_volume_io PRIVATE support/plugin_reader_main.cpp)

# OpenVDB's templates take the compiler longer than the tests take; without optimization the tests take longer still.
file(GLOB vdb_reader_tests CONFIGURE_DEPENDS unit/volume_io/openvdb/*.cpp)
add_library(vdb_reader_tests OBJECT ${vdb_reader_tests})
target_compile_options(vdb_reader_tests PRIVATE -O1)
target_include_directories(vdb_reader_tests PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(vdb_reader_tests PRIVATE isoextract_volume_io isoextract_options GTest::gtest openvdb_library)
isoextract_see_all(vdb_reader_tests volume_io)
target_compile_definitions(vdb_reader_tests PRIVATE ISOEXTRACT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
target_link_libraries(test_volume_io PRIVATE vdb_reader_tests openvdb_library)
