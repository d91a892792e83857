isoextract_unit_test(mesh
  adjacency_test.cpp attribute_map_test.cpp attributes_test.cpp components_test.cpp exact_sign_test.cpp greatest_distance_test.cpp joined_test.cpp
  metrics_test.cpp shading_normals_test.cpp topology_test.cpp triangle_tree_test.cpp vertex_fans_test.cpp)
