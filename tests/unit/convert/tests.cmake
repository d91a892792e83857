# Builds samples/convert_two and checks that it writes two meshes at once.
add_executable(convert_two ${PROJECT_SOURCE_DIR}/samples/convert_two.cpp)
target_link_libraries(convert_two PRIVATE isoextract_convert isoextract_options)
add_test(NAME convert.example_of_two_at_once
  COMMAND convert_two demo:sphere?size=24 0 two_a.ply demo:torus?size=32 0 two_b.glb)
set_tests_properties(convert.example_of_two_at_once PROPERTIES
  PASS_REGULAR_EXPRESSION "wrote two_a.ply: [0-9]+ triangles\n.*wrote two_b.glb: [0-9]+ triangles")
