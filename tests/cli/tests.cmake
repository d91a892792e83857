# Whole command lines: stdout, stderr, exit codes, and what was written. support.py limits the processor time of each run;
# the time that passes meanwhile is limited only so that a test that hangs ends.
set(hanging_seconds 1500)
foreach(name
    animate attributes attribute_files attribute_kinds batch batch_faults batch_rules shards merge names spreadsheets iso particles particle_limits particle_sequences config startup usage
    surface placement true_error frames output overwrite interrupted streams inputs lost_input plugin openvdb fields memory info grids compare
    support hostile_names several_grids simplify compression resolution error bench documents report simulate jet stability far verify verify_edits gpu readme render
    render_gpu voxels child damaged_libraries pictures pieces piece_sequences check normals labels arrays region told net_sides)
  add_test(NAME cli.${name}
    COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/${name}_test.py)
  set_tests_properties(cli.${name} PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT ${hanging_seconds})
endforeach()
# Its plug-ins are those of tests/plugins.
set_property(TEST cli.plugin cli.child APPEND PROPERTY ENVIRONMENT "ISOEXTRACT_TEST_PLUGINS=${test_plugins}")

# Sanitizers want to be the first library of a process, which is not what the portable folder is about; nor is what is
# installed.
if(NOT ISOEXTRACT_SANITIZE)
  add_test(NAME cli.portable COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/portable_test.py)
  set_tests_properties(cli.portable PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT ${hanging_seconds})

  # The sanitizers start threads of their own.
  add_test(NAME cli.threads COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/threads_test.py)
  set_tests_properties(cli.threads PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT ${hanging_seconds})

  add_test(NAME cli.install COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/install_test.py)
  set_tests_properties(cli.install PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR};ISOEXTRACT_BINARY_DIR=${PROJECT_BINARY_DIR};ISOEXTRACT_TEST_PLUGINS=${test_plugins}"
    TIMEOUT ${hanging_seconds})

  add_test(NAME cli.measure COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/measure_test.py)
  set_tests_properties(cli.measure PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT ${hanging_seconds})
endif()
