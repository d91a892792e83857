isoextract_unit_test(mesh metrics_test.cpp topology_test.cpp vertex_fans_test.cpp)
