isoextract_unit_test(simulate
  terrain_test.cpp water_fields_test.cpp water_stability_test.cpp water_test.cpp)
