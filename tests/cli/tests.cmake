# Whole command lines: stdout, stderr, exit codes, and what was written.
foreach(name startup usage surface placement output streams lost_input info compare simplify resolution error bench documents report stability far verify gpu readme)
  add_test(NAME cli.${name}
    COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/${name}_test.py)
  set_tests_properties(cli.${name} PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT 120)
endforeach()

# Sanitizers want to be the first library of a process, which is not what the folder is about.
if(NOT ISOEXTRACT_SANITIZE)
  add_test(NAME cli.portable COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/portable_test.py)
  set_tests_properties(cli.portable PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT 300)

  add_test(NAME cli.measure COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/measure_test.py)
  set_tests_properties(cli.measure PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT 300)
endif()
