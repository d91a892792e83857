isoextract_unit_test(simulate
  fluid_test.cpp particle_jet_test.cpp terrain_test.cpp water_fields_test.cpp water_stability_test.cpp water_test.cpp)
