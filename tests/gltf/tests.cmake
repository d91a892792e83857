# Every kind of .glb and .gltf that the writers can make, checked by the Khronos validator.
add_executable(write_sample_meshes gltf/write_sample_meshes.cpp)
target_link_libraries(write_sample_meshes PRIVATE isoextract_mesh_io isoextract_options)
target_include_directories(write_sample_meshes PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})

set(sample_meshes ${CMAKE_CURRENT_BINARY_DIR}/sample_meshes)
add_test(NAME gltf.write_samples COMMAND write_sample_meshes ${sample_meshes})
set_tests_properties(gltf.write_samples PROPERTIES FIXTURES_SETUP sample_meshes)

# Where node is missing the test fails: a missing test would remain unnoticed.
find_program(NODE NAMES node nodejs)
set(validate ${NODE} ${CMAKE_CURRENT_SOURCE_DIR}/gltf/validate.mjs ${sample_meshes}/glb ${sample_meshes}/gltf
  ${sample_meshes}/animated)
if(NOT NODE)
  set(validate sh -c "echo 'no node when cmake ran: scripts/setup.sh test installs it'; exit 1")
endif()
add_test(NAME gltf.validate COMMAND ${validate})
# The decoders that programs on the web use.
string(REPLACE validate.mjs decode.mjs decode "${validate}")
add_test(NAME gltf.decode COMMAND ${decode})
set_tests_properties(gltf.validate gltf.decode PROPERTIES FIXTURES_REQUIRED sample_meshes)
