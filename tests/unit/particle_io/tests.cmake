include(${PROJECT_SOURCE_DIR}/cmake/OpenVDB.cmake)

target_sources(test_particle_io PRIVATE support/plugin_reader_main.cpp)
# Together these files take the compiler very much longer than one by one.
set_target_properties(test_particle_io PROPERTIES UNITY_BUILD OFF)
# OpenVDB's templates take the compiler longer than the test takes.
set_source_files_properties(unit/particle_io/openvdb_points_test.cpp PROPERTIES COMPILE_OPTIONS -O1)
target_link_libraries(test_particle_io PRIVATE openvdb_library)
