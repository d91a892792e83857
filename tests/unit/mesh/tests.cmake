isoextract_unit_test(mesh attributes_test.cpp metrics_test.cpp topology_test.cpp vertex_fans_test.cpp)
