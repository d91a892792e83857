# Plug-ins that only the tests use, in a folder of their own.
set(test_plugins ${PROJECT_BINARY_DIR}/test-plugins)
isoextract_volume_plugin(text TITLE "volumes as text" EXTENSIONS .tvol .textvol FOLDER ${test_plugins}
  SOURCES ${CMAKE_CURRENT_SOURCE_DIR}/plugins/text_volume.cpp)
target_compile_definitions(isoextract_volume_text PRIVATE TEXT_VOLUME_VERSION=4 TEXT_VOLUME_ID="text")
isoextract_volume_plugin(newer TITLE "volumes of another version" EXTENSIONS .newer FOLDER ${test_plugins}
  SOURCES ${CMAKE_CURRENT_SOURCE_DIR}/plugins/text_volume.cpp)
target_compile_definitions(isoextract_volume_newer PRIVATE TEXT_VOLUME_VERSION=5 TEXT_VOLUME_ID="newer")
isoextract_volume_plugin(hostile TITLE "volumes that do harm" EXTENSIONS .hostile FOLDER ${test_plugins}
  SOURCES ${CMAKE_CURRENT_SOURCE_DIR}/plugins/hostile_volume.cpp)
target_include_directories(isoextract_volume_hostile PRIVATE ${PROJECT_SOURCE_DIR}/src)
add_dependencies(test_volume_io isoextract_volume_text isoextract_volume_newer isoextract_volume_hostile)
set_source_files_properties(unit/volume_io/plugin_volumes_test.cpp PROPERTIES
  COMPILE_DEFINITIONS TEST_PLUGINS="${test_plugins}")

# The one for VTK's particles, which is built where VTK is found.
set_source_files_properties(unit/particle_io/particles_vtk_test.cpp PROPERTIES
  COMPILE_DEFINITIONS "BUILT_PLUGINS=\"${PROJECT_BINARY_DIR}/plugins\";BUILT_VTK=$<TARGET_EXISTS:isoextract_particles_vtk>")
if(TARGET isoextract_particles_vtk)
  add_dependencies(test_particle_io isoextract_particles_vtk)
endif()

# Likewise those around OpenVDB.
set_source_files_properties(unit/volume_io/openvdb/openvdb_plugin_test.cpp
  unit/volume_io/openvdb/openvdb_tools_test.cpp unit/particle_io/openvdb_points_test.cpp PROPERTIES
  COMPILE_DEFINITIONS
  "BUILT_PLUGINS=\"${PROJECT_BINARY_DIR}/plugins\";BUILT_OPENVDB=$<TARGET_EXISTS:isoextract_volume_openvdb>")
if(TARGET isoextract_volume_openvdb)
  add_dependencies(test_volume_io isoextract_volume_openvdb isoextract_grids_openvdb)
  add_dependencies(test_particle_io isoextract_particles_openvdb)
endif()
