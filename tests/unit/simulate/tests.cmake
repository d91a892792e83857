isoextract_unit_test(simulate particle_jet_test.cpp fluid_test.cpp)
