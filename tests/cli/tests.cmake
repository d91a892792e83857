# Whole command lines: stdout, stderr, exit codes, and what was written. support.py limits the processor time of each run;
# the time that passes meanwhile is limited only so that a test that hangs ends.
set(hanging_seconds 1500)
file(GLOB files CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR}/cli ${CMAKE_CURRENT_SOURCE_DIR}/cli/*_test.py)
list(TRANSFORM files REPLACE "_test\\.py$" "" OUTPUT_VARIABLE names)
list(REMOVE_ITEM names portable threads install measure)  # which come below
foreach(name IN LISTS names)
  add_test(NAME cli.${name}
    COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/cli/${name}_test.py)
  set_tests_properties(cli.${name} PROPERTIES
    ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
    TIMEOUT ${hanging_seconds})
endforeach()
# Its plug-ins are those of tests/plugins.
set_property(TEST cli.plugin cli.child cli.compressed APPEND PROPERTY ENVIRONMENT "ISOEXTRACT_TEST_PLUGINS=${test_plugins}")

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
